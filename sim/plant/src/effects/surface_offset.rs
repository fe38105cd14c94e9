//! `surface-offset`: the wall is not where it was believed.

use super::{Change, Definition, EffectError, Host, HostKind, Parameter, Place, values};
use crate::assembly::Assembly;
use crate::units::Dimension;

pub(super) static DEFINITION: Definition = Definition {
    kind: "surface-offset",
    place: Place::Contact,
    hosts: &[HostKind::Contact],
    site: "",
    parameters: &[Parameter::linear("offset", Dimension::LENGTH, Some(0.0), 5e-4, (-10.0, 10.0), "how much farther away the surface is")],
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
    dissipative: false,
    change: Change::Plant(apply),
};

fn apply(machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
    let [offset] = values(parameters);
    machine.contact_mut(host, &DEFINITION)?.gap += offset;
    Ok(())
}
