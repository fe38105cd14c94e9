//! `command-delay`: the command arrives late.

use super::{Change, Definition, EffectError, Host, HostKind, Parameter, Place, Scale};
use crate::assembly::Assembly;
use crate::units::Dimension;

pub(super) static DEFINITION: Definition = Definition {
    kind: "command-delay",
    place: Place::Drive,
    hosts: &[HostKind::Actuator],
    parameters: &[Parameter {
        name: "delay",
        dimension: Dimension::TIME,
        null: Some(0.0),
        typical: 1e-3,
        bounds: (0.0, 1.0),
        scale: Scale::Linear,
        default: None,
        text: "how much later the drive acts on each command",
    }],
    summary: "the command arrives late, by any real number of seconds",
    documentation: "\
## Model
The drive receives `u(t - delay)`. Commands are held between controller samples, so the delayed command is placed exactly in time, whatever the step.

## Where it comes from
Field buses, computation time that the controller's own `delay` does not count, buffered amplifiers.

## How it shows
Phase of the drive's response falls in proportion to frequency, at unchanged size. It is confused with `actuator-lag`, from which it departs only at second order in frequency times delay.

## Source
K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, section 2.3 (systems with time delay).
",
    dissipative: false,
    change: Change::Plant(apply),
};

fn apply(machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
    let drive = machine.drive_mut(host, DEFINITION.kind)?;
    drive.delay += parameters[0];
    Ok(())
}
