//! `force-delay`: the force reading is late.

use super::{Change, Definition, EffectError, Host, HostKind, Parameter, Place, values};
use crate::assembly::Assembly;
use crate::units::Dimension;

pub(super) static DEFINITION: Definition = Definition {
    kind: "force-delay",
    place: Place::ForceSensor,
    hosts: &[HostKind::ForceSensor],
    site: "",
    parameters: &[Parameter::linear("delay", Dimension::TIME, Some(0.0), 1e-3, (0.0, 1.0), "how much later the reading is than the force")],
    summary: "the force reading is late",
    documentation: "\
## Model
The sensor reads `F(t - delay)`.

## Where it comes from
Converters with a digital filter, field buses, a separate force-torque box that sends packets.

## How it shows
Impacts are recorded late and otherwise unchanged; a force loop loses phase in proportion to frequency. Positions
recorded beside it are on time, which parts it from `command-delay`. `force-lag` also lowers the peaks.

## Source
K. J. Åström and B. Wittenmark, Computer-Controlled Systems, Prentice Hall (1997): sampling of systems with a time
delay.
",
    dissipative: false,
    change: Change::Plant(apply),
};

fn apply(machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
    let [delay] = values(parameters);
    machine.sensor_mut(host, &DEFINITION)?.delay += delay;
    Ok(())
}
