//! `slew-limit`: the drive force cannot change faster.

use super::{ABOVE_ZERO, Change, Definition, EffectError, Host, HostKind, Parameter, Place, values};
use crate::assembly::Assembly;
use crate::units::Dimension;

pub(super) static DEFINITION: Definition = Definition {
    kind: "slew-limit",
    place: Place::Drive,
    hosts: &[HostKind::Actuator],
    site: "",
    parameters: &[Parameter::log("rate", Dimension::FORCE_RATE, Some(f64::INFINITY), 5e3, (ABOVE_ZERO, f64::INFINITY), "fastest change")],
    summary: "the drive force cannot change faster",
    documentation: "\
## Model
What the drive acts on follows the command with `|df/dt| <= rate`, after gain and limit and before any lag. Of several
limits the smallest holds. On a velocity source it is the commanded speed that is held back.

## Where it comes from
Ramps in the set point, a supply voltage that limits how fast current rises in a winding, valves.

## How it shows
Steps become ramps, and sines triangles once amplitude times angular frequency exceeds the rate; from there the phase
lag grows with amplitude, which can start an oscillation that small tests never show. At one amplitude `actuator-lag`
looks the same; two amplitudes part them.

## Source
P. Hippe, Windup in Control: Its Effects and Their Prevention, Springer (2006): rate constraints.
",
    dissipative: false,
    change: Change::Plant(apply),
};

fn apply(machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
    let [rate] = values(parameters);
    let drive = machine.drive_mut(host, &DEFINITION)?;
    drive.rate_limit = drive.rate_limit.min(rate);
    Ok(())
}
