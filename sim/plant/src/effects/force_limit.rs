//! `force-limit`: the drive force is clipped.

use super::{ABOVE_ZERO, Change, Definition, EffectError, Host, HostKind, Parameter, Place, values};
use crate::assembly::Assembly;
use crate::units::Dimension;

pub(super) static DEFINITION: Definition = Definition {
    kind: "force-limit",
    place: Place::Drive,
    hosts: &[HostKind::Actuator],
    site: "",
    parameters: &[Parameter::log("limit", Dimension::FORCE, Some(f64::INFINITY), 200.0, (ABOVE_ZERO, f64::INFINITY), "largest force")],
    summary: "the drive force is clipped",
    documentation: "\
## Model
The drive acts on the command clipped to `[-limit, limit]`, after its gain and before any lag. Of several limits the
smallest holds.

## Where it comes from
Amplifier current, motor temperature, a slipping clutch, a parameter in the drive that nobody remembers.

## How it shows
Nothing below the limit; above it the force is flat, impacts and large steps fall short, and an integrating controller
winds up and overshoots. `slew-limit` also shows in large and fast commands only, but it skews them and does not cap
slow ones.

## Source
K. J. Åström and T. Hägglund, Advanced PID Control, ISA (2006): actuator limits and windup.
",
    dissipative: false,
    change: Change::Plant(apply),
};

fn apply(machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
    let [limit] = values(parameters);
    let drive = machine.drive_mut(host, &DEFINITION)?;
    drive.limit = drive.limit.min(limit);
    Ok(())
}
