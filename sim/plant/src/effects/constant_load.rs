//! `constant-load`: gravity or a cable pull.

use super::prelude::*;

parameters! { ConstantLoad
    force: linear(Dimension::FORCE, Some(0.0), 10.0, (-1e6, 1e6), "force on the second body of the spring"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ConstantLoad::KIND,
    name: "constant-load",
    place: Place::Guide,
    order: 120,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: ConstantLoad::PARAMETERS,
    summary: "gravity or a cable pull",
    example: "\
[springs.guide.effects.constant-load]
force = \"-15 N\"
",
    sections: "\
## Model
A constant force acts on the second body of the spring, and its opposite on the first. Under a guide
`between = [\"ground\", \"motor\"]` a positive one pushes the motor towards the workpiece. Where the first
body is a base that moves, the pair is internal, as of a cable. The base does not feel it as a weight.

## Where it comes from
Weight on an inclined axis, a counterbalance that is not quite right, hoses, cable chains.

## How it shows
The command that holds the axis still is not zero, and free motion is faster one way than the other.
`asymmetric-friction` shows the same difference in motion, beside the step of dry friction. Dry friction
together with a load that it can hold is exactly `asymmetric-friction`, moving and at rest. In contact under
force control `force-bias` shifts the command as well; the command at rest in free motion separates them.

## How it is recognised
The missing force has a mean that depends neither on speed nor on command. Hold the axis at rest in free
motion and read the command; dry friction hides a load up to its level.

## Numerical treatment
It is a constant term of the linear equations and exact. Linear theory omits it: on a linear machine a
constant does not change the motion about the state of rest.

## Source
B. Siciliano, L. Sciavicco, L. Villani and G. Oriolo, Robotics: Modelling, Planning and Control, Springer
(2009): gravity in the equations of motion.
",
    law: LawDrawing {
        axes: ["position", "load"],
        start: -1.0,
        with: &[Curve::Points(&[(-1.0, 0.6), (1.0, 0.6)])],
        without: &[],
        labels: &[(0.4, 0.7, "force")],
    },
    traits: &[Trait::PlainNumber],
    change: Change::plant::<ConstantLoad>(),
};

impl ChangesPlant for ConstantLoad {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { force } = self;
        machine.link_mut(host, &DEFINITION)?.load += force;
        Ok(())
    }
}
