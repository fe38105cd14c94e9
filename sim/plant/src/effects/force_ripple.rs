//! `force-ripple`: cogging: a force periodic in position.

use std::f64::consts::TAU;

use super::{ABOVE_ZERO, Change, Definition, EffectError, Host, HostKind, Parameter, Place, values};
use crate::assembly::{Assembly, Ripple};
use crate::units::Dimension;

pub(super) static DEFINITION: Definition = Definition {
    kind: "force-ripple",
    place: Place::Drive,
    hosts: &[HostKind::Actuator],
    site: "",
    parameters: &[
        Parameter::log("amplitude", Dimension::FORCE, Some(0.0), 5.0, (0.0, 1e6), "largest ripple force"),
        Parameter::log("pitch", Dimension::LENGTH, None, 0.03, (ABOVE_ZERO, 1e3), "distance after which the ripple repeats"),
        Parameter::linear("phase", Dimension::NONE, None, 1.0, (-TAU, TAU), "phase of the ripple at position zero, rad"),
    ],
    summary: "cogging: a force periodic in position",
    documentation: "\
## Model
The drive adds the force `amplitude sin(2 pi x / pitch + phase)`, `x` the position of the driven body relative to the
one that carries the reaction. It acts whatever the command.

## Where it comes from
Permanent magnets that pull at teeth and at the ends of an iron core, gears, ball screws.

## How it shows
The missing force repeats with position, not with time: its frequency rises with speed. Over a stroke much shorter
than the pitch it is a constant and a slope: `constant-load` then looks the same. A slow axis rests in its valleys
much as under `coulomb-friction`, but it returns its energy.

## Source
J. F. Gieras, Z. J. Piech and B. Z. Tomczuk, Linear Synchronous Motors, CRC Press (2011): cogging and force ripple.
",
    dissipative: false,
    change: Change::Plant(apply),
};

fn apply(machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
    let [amplitude, pitch, phase] = values(parameters);
    let drive = machine.drive_mut(host, &DEFINITION)?;
    if amplitude > 0.0 {
        drive.ripples.push(Ripple { amplitude, pitch, phase });
    }
    Ok(())
}
