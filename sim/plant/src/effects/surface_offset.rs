//! `surface-offset`: the wall is not at its believed position.

use super::prelude::*;

parameters! { SurfaceOffset
    offset: linear(Dimension::LENGTH, Some(0.0), 5e-4, (-10.0, 10.0), "how much farther away the surface is"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: SurfaceOffset::KIND,
    name: "surface-offset",
    place: Place::Contact,
    order: 330,
    hosts: &[HostKind::Contact],
    site: "",
    parameters: SurfaceOffset::PARAMETERS,
    summary: "the wall is not where it was believed",
    example: "\
[contacts.tool.effects.surface-offset]
offset = \"0.5 mm\"
",
    sections: "\
## Model
The gap to close before the bodies touch is `offset` larger than believed. A clamped contact is attached where
the bodies are, so it does not notice.

## Where it comes from
Part tolerances, fixtures set up anew, thermal growth, an axis that was homed elsewhere.

## How it shows
After an approach at constant speed, touch-down comes late (or early) by `offset` over that speed. Under force
control everything after it is as predicted but shifted. At a single approach speed a `command-delay` shifts
it alike, but it also delays free motion. Under stiff position control the force is lower by `k offset`. If
the axis yields, `k` is the stiffness of wall and axis in series. A `force-bias` makes the same error and
changes no position.

## How it is recognised
The touch-down is early or late by one distance at every approach speed. A delay would shift it by one time.

## Numerical treatment
The gap of the contact changes; the touch is an event at its true instant. Linear theory does not depend on
it.

## Source
B. Siciliano and L. Villani, Robot Force Control, Kluwer (1999): compliance to an environment whose position
is uncertain.
",
    law: LawDrawing {
        axes: ["position", "contact force"],
        start: 0.0,
        with: &[Curve::Points(&[(0.0, 0.0), (0.5, 0.0), (1.0, 0.8)])],
        without: &[Curve::Points(&[(0.0, 0.0), (0.3, 0.0), (0.8, 0.8)])],
        labels: &[(0.62, 0.06, "offset")],
    },
    traits: &[],
    change: Change::plant::<SurfaceOffset>(),
};

impl ChangesPlant for SurfaceOffset {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { offset } = self;
        machine.contact_mut(host, &DEFINITION)?.gap += offset;
        Ok(())
    }
}
