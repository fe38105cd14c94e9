//! `surface-offset`: the wall is not where it was believed.

use super::{Change, ChangesPlant, Definition, EffectError, Host, HostKind, Parameters, Place};
use crate::assembly::Assembly;
use crate::units::Dimension;

parameters! { SurfaceOffset
    offset: linear(Dimension::LENGTH, Some(0.0), 5e-4, (-10.0, 10.0), "how much farther away the surface is"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: SurfaceOffset::KIND,
    name: "surface-offset",
    place: Place::Contact,
    hosts: &[HostKind::Contact],
    site: "",
    parameters: SurfaceOffset::PARAMETERS,
    summary: "the wall is not where it was believed",
    documentation: "\
## Model
The gap to close before the bodies touch is `offset` larger than believed. A clamped contact is attached where the
bodies stand, so it does not notice.

## Where it comes from
Part tolerances, fixtures set up anew, thermal growth, an axis that was homed elsewhere.

## How it shows
Touch-down comes late (or early) by `offset` over the approach speed, and everything after it is as predicted but
shifted. With a single approach speed `command-delay` shifts it as much, but it also delays free motion. Under
position control it is a force error of `k offset`, as `force-bias` makes without changing any position.

## Source
B. Siciliano and L. Villani, Robot Force Control, Kluwer (1999): compliance to an environment whose position is
uncertain.
",
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
