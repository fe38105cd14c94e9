//! `viscous-friction`: added to the guide's damping.

use super::{Change, Definition, EffectError, Host, HostKind, Parameter, Place, values};
use crate::assembly::Assembly;
use crate::units::Dimension;

pub(super) static DEFINITION: Definition = Definition {
    kind: "viscous-friction",
    place: Place::Guide,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: &[Parameter::log("damping", Dimension::DAMPING, Some(0.0), 60.0, (0.0, 1e9), "beyond the damping of the guide")],
    summary: "added to the guide's damping",
    documentation: "\
## Model
The guide resists with `damping v` on top of the damping it has.

## Where it comes from
Grease and oil, eddy currents, back-EMF of a motor that is not modelled, air in a bellows.

## How it shows
The missing force is proportional to velocity: free motion reaches less speed for the same force, and modes that
stretch the guide are better damped. At one speed `coulomb-friction` takes as much; over a range of speeds a line and
a step part. In contact little moves in the guide, and `contact-damping` is what damps the oscillation there.

## Source
B. Armstrong-Hélouvry, Control of Machines with Friction, Kluwer (1991).
",
    dissipative: true,
    change: Change::Plant(apply),
};

fn apply(machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
    let [damping] = values(parameters);
    machine.link_mut(host, &DEFINITION)?.damping += damping;
    Ok(())
}
