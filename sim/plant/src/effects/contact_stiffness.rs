//! `contact-stiffness`: another stiffness of the contact.

use super::prelude::*;

parameters! { ContactStiffness
    stiffness: log(Dimension::STIFFNESS, None, 1.2e5, (ABOVE_ZERO, 1e12), "in place of the believed one"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ContactStiffness::KIND,
    name: "contact-stiffness",
    place: Place::Contact,
    order: 290,
    hosts: &[HostKind::Contact],
    site: "",
    parameters: ContactStiffness::PARAMETERS,
    summary: "the contact's stiffness differs from the believed one",
    example: "\
[contacts.tool.effects.contact-stiffness]
stiffness = \"120 kN/m\"
",
    sections: "\
## Model
The elastic force is `stiffness d` in place of the believed `k d`. Where the law of the contact is a power of
the compression, `stiffness` is its coefficient in N/m^n; write it as a plain SI number. At the value that
the contact has, the effect is absent.

## Where it comes from
Another material than planned, a worn or exchanged pad, a sensor whose own stiffness was taken from a data
sheet.

## How it shows
Let `r` be the stiffness over the believed one. The peak force of an impact and the frequency of the contact
mode rise by `sqrt(r)`, and its duration falls by as much. Above the contact mode the gain of a force loop is
in proportion to the stiffness. Well below it, a force drive gives the same contact force on any wall. On a
motion-controlled robot the gain is in proportion at all frequencies (Whitney). Static force under force
control is as predicted. At low frequency `workpiece-dynamics` and `transmission-flexibility` are a softer
contact too; only a mode separates them. `force-gain` changes the reading in proportion as well, but no
frequency.

## How it is recognised
The duration of impacts and the frequency of the contact mode are off, while static forces are right.
Compare with a record of position under known force.

## Numerical treatment
The stiffness of the contact is replaced, and a linear contact stays exact. Linear theory uses the new value.

## Source
D. E. Whitney, Force feedback control of manipulator fine motions, ASME Journal of Dynamic Systems,
Measurement, and Control 99 (1977): the loop gain is proportional to the stiffness.
",
    law: LawDrawing {
        axes: ["compression", "elastic contact force"],
        start: 0.0,
        with: &[Curve::Points(&[(0.0, 0.0), (1.0, 0.9)])],
        without: &[Curve::Points(&[(0.0, 0.0), (1.0, 0.5)])],
    },
    traits: &[],
    change: Change::plant::<ContactStiffness>(),
};

impl ChangesPlant for ContactStiffness {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { stiffness } = self;
        machine.contact_mut(host, &DEFINITION)?.law.stiffness = stiffness;
        Ok(())
    }
}
