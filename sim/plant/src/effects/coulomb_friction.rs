//! `coulomb-friction`: dry friction, set-valued at rest.

use super::{Change, Definition, EffectError, Host, HostKind, Parameter, Place, Scale};
use crate::assembly::Assembly;
use crate::units::Dimension;

pub(super) static DEFINITION: Definition = Definition {
    kind: "coulomb-friction",
    place: Place::Guide,
    hosts: &[HostKind::Spring],
    parameters: &[Parameter {
        name: "level",
        dimension: Dimension::FORCE,
        null: Some(0.0),
        typical: 10.0,
        bounds: (0.0, 1e6),
        scale: Scale::Log,
        default: None,
        text: "friction force while sliding, and the largest one at rest",
    }],
    summary: "dry friction, set-valued at rest",
    documentation: "\
## Model
Sliding at speed `v`, the guide resists with `level * sign(v)`; at rest it takes whatever value up to `level` keeps it at rest. Stick and slip are separate modes of the machine, and the instants between them are located.

## Where it comes from
Seals, plain bearings, preloaded guides and screws, brushes.

## How it shows
The missing force is a step at every reversal of the velocity, of a size that does not depend on speed: relative to the command it matters less the larger the motion. Near rest the axis sticks, and an integrating controller hunts.

## Source
H. Olsson et al., Friction models and friction compensation, European Journal of Control 4 (1998), section 2.
",
    dissipative: true,
    change: Change::Plant(apply),
};

fn apply(machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
    let friction = &mut machine.link_mut(host, DEFINITION.kind)?.friction;
    friction.forward += parameters[0];
    friction.backward += parameters[0];
    Ok(())
}
