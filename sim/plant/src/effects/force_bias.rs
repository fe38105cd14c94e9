//! `force-bias`: offset.

use super::{Change, Definition, EffectError, Host, HostKind, Parameter, Place, values};
use crate::assembly::Assembly;
use crate::units::Dimension;

pub(super) static DEFINITION: Definition = Definition {
    kind: "force-bias",
    place: Place::ForceSensor,
    hosts: &[HostKind::ForceSensor],
    site: "",
    parameters: &[Parameter::linear("bias", Dimension::FORCE, Some(0.0), 2.0, (-1e6, 1e6), "reading at zero force")],
    summary: "offset",
    documentation: "\
## Model
The reading is `bias` more than it would be.

## Where it comes from
Drift with temperature, a sensor zeroed in another pose, the weight of the tool, a mounting that strains it.

## How it shows
The reading is off by the same amount in free motion and in contact, and a threshold that detects contact trips early
or late. In contact under force control `constant-load` shifts the command as much, but free of contact the reading
stays at zero. `surface-offset` changes the force only while there is contact.

## Source
E. O. Doebelin, Measurement Systems: Application and Design, McGraw-Hill (2004): zero drift.
",
    dissipative: false,
    change: Change::Plant(apply),
};

fn apply(machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
    let [bias] = values(parameters);
    machine.sensor_mut(host, &DEFINITION)?.bias += bias;
    Ok(())
}
