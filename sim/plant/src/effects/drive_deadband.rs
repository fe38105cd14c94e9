//! `drive-deadband`: commands within the width do nothing, and beyond it the width is lost.

use super::{Change, Definition, EffectError, Host, HostKind, Parameter, Place, values};
use crate::assembly::Assembly;
use crate::units::Dimension;

pub(super) static DEFINITION: Definition = Definition {
    kind: "drive-deadband",
    place: Place::Drive,
    hosts: &[HostKind::Actuator],
    site: "",
    parameters: &[Parameter::log("width", Dimension::FORCE, Some(0.0), 5.0, (0.0, 1e6), "size up to which a command does nothing")],
    summary: "commands within the width do nothing, and beyond it the width is lost",
    documentation: "\
## Model
The drive acts on `u - width sign(u)` for `|u| > width` and on zero otherwise. On a velocity source the command, and
so the width, is a speed.

## Where it comes from
Overlapped valves, amplifiers with a dead time between the two halves of a bridge, a threshold in the set point.

## How it shows
A force of constant size is missing, and it has the sign of the command: it matters less the larger the command.
`coulomb-friction` takes the same size with the sign of the velocity; the two agree while the drive pushes the way it
moves and part where it brakes, and where a resting axis is pushed from outside.

## Source
G. Tao and P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley (1996): the
dead-zone.
",
    dissipative: false,
    change: Change::Plant(apply),
};

fn apply(machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
    let [width] = values(parameters);
    machine.drive_mut(host, &DEFINITION)?.deadband += width;
    Ok(())
}
