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
the compression, `stiffness` is its coefficient in N/m^n; write it as a plain SI number. At the value that the
contact has, the effect is absent. A `hertz-contact` under the same contact replaces this stiffness.

## Where it comes from
Another material than planned, a worn or exchanged pad, a sensor whose own stiffness was taken from a data
sheet.

## How it shows
Let `r` be the ratio of the stiffness to the believed one. In a linear contact of little damping, the peak
force of an impact and the frequency of the contact mode are `sqrt(r)` times as large. An impact lasts
`1 / sqrt(r)` times as long. For a power `n` of the compression the peak is `r^(1/(n+1))` times as large,
and the duration one over that. The frequency at a given force is `r^(1/(2n))` times as high. Above the
contact mode, the gain of a force loop is proportional to the stiffness. Well below it, a force drive gives
the same contact force on any wall. On a motion-controlled robot the gain is proportional to the stiffness at
all frequencies (Whitney). Static force under force control is as predicted. At low frequency,
`workpiece-dynamics` and `transmission-flexibility` also act as a softer contact; only their modes separate
them. `force-gain` scales the reading too, but leaves the contact mode.

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
        labels: &[(0.3, 0.55, "stiffness")],
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
