//! `contact-damping`: another damping of the contact.

use super::prelude::*;

parameters! { ContactDamping
    damping: log(Dimension::DAMPING, None, 250.0, (0.0, 1e9), "in place of the believed one"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ContactDamping::KIND,
    name: "contact-damping",
    place: Place::Contact,
    order: 300,
    hosts: &[HostKind::Contact],
    site: "",
    parameters: ContactDamping::PARAMETERS,
    summary: "the contact's damping differs from the believed one",
    example: "\
[contacts.tool.effects.contact-damping]
damping = \"500 N s/m\"
",
    sections: "\
## Model
The viscous part of the contact force is `damping d'` in place of the believed one, `d` the compression. At
the value that the contact has, the effect is absent.

## Where it comes from
Rubber, foam, grease, squeeze films.

## How it shows
Bounces lose more (or less) energy, and the contact mode rings for a shorter (or longer) time at nearly the
same frequency. The share of energy that an impact loses does not depend on its speed; in a
`hunt-crossley-contact` it grows with the speed. The force at touch-down separates them too: with
`contact-damping` it begins with a step, with the other from zero. `viscous-friction` damps free motion as
well.

## How it is recognised
Impacts lose more or less energy than predicted, and the contact mode rings for a different time at the same
frequency.

## Numerical treatment
The damping of the contact is replaced, and a linear contact stays exact. The force of a damped touch-down
starts with a step, and the contact opens when its force reaches zero. Linear theory uses the new value.

## Source
G. Gilardi and I. Sharf, Literature survey of contact dynamics modelling, Mechanism and Machine Theory 37
(2002): the spring-dashpot model.
",
    law: LawDrawing {
        axes: ["rate of compression", "viscous contact force"],
        start: -1.0,
        with: &[Curve::Points(&[(-1.0, -0.8), (1.0, 0.8)])],
        without: &[Curve::Points(&[(-1.0, -0.4), (1.0, 0.4)])],
        labels: &[(0.1, 0.6, "damping")],
    },
    traits: &[],
    change: Change::plant::<ContactDamping>(),
};

impl ChangesPlant for ContactDamping {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { damping } = self;
        machine.contact_mut(host, &DEFINITION)?.law.damping = damping;
        Ok(())
    }
}
