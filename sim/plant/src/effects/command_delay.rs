//! `command-delay`: the command arrives late, by any real number of seconds.

use super::{Change, Definition, EffectError, Host, HostKind, Parameter, Place, values};
use crate::assembly::Assembly;
use crate::units::Dimension;

pub(super) static DEFINITION: Definition = Definition {
    kind: "command-delay",
    place: Place::Drive,
    hosts: &[HostKind::Actuator],
    site: "",
    parameters: &[Parameter::linear("delay", Dimension::TIME, Some(0.0), 1e-3, (0.0, 1.0), "how late the drive acts on each command")],
    summary: "the command arrives late, by any real number of seconds",
    documentation: "\
## Model
The drive receives `u(t - delay)`. Commands are held between controller samples, so the delayed command is placed
exactly in time, whatever the step.

## Where it comes from
Field buses, computation time that the controller's own `delay` does not count, buffered amplifiers.

## How it shows
The phase of every response to the command falls in proportion to frequency, at unchanged size. `actuator-lag` departs
from it only at second order in frequency times delay. `force-delay` costs a force loop the same phase, but free
motion does not show it.

## Source
K. J. Åström and B. Wittenmark, Computer-Controlled Systems, Prentice Hall (1997): sampling of systems with a time
delay.
",
    dissipative: false,
    change: Change::Plant(apply),
};

fn apply(machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
    let [delay] = values(parameters);
    machine.drive_mut(host, &DEFINITION)?.delay += delay;
    Ok(())
}
