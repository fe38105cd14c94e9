//! `asymmetric-friction`: dry friction with one level per direction.

use super::{
    Change, ChangesPlant, Curve, Definition, EffectError, Host, HostKind, Law, Parameters, Place, Trait,
};
use crate::assembly::Assembly;
use crate::units::Dimension;

parameters! { AsymmetricFriction
    level: log(Dimension::FORCE, Some(0.0), 10.0, (0.0, 1e6), "mean of the two levels"),
    asymmetry: linear(
        Dimension::NONE, None, 0.3, (-1.0, 1.0), "half the difference of the levels, over their mean"
    ),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: AsymmetricFriction::KIND,
    name: "asymmetric-friction",
    place: Place::Guide,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: AsymmetricFriction::PARAMETERS,
    summary: "dry friction of two levels, one for each direction",
    documentation: "\
## Example
```toml
[springs.guide.effects.asymmetric-friction]
level = \"6 N\"
asymmetry = 0.5
```
`feeler run scenarios/effects/asymmetric-friction.toml` runs it.

## Model
Sliding towards +, the guide resists with `level (1 + asymmetry)`, towards - with `level (1 - asymmetry)`;
at rest it holds up to the level of the direction in which it would start.

## Where it comes from
Lip seals, worn or tilted guides, gears whose two flanks differ.

## How it shows
In steady motion it is `coulomb-friction` of the mean level and a `constant-load` of the size
`level asymmetry`; the load would also have to be carried at rest, and friction would not. Where the axis
only ever moves one way the three cannot be told apart.

## How it is recognised
Compare slow strokes in both directions, then release the axis at rest: friction lets go of it, a load does
not.

## Numerical treatment
As dry friction with one level: modes for sliding either way and for sticking, with events between them.
Linear theory takes friction as sliding one way.

## Source
C. Canudas de Wit, K. J. Åström and K. Braun, Adaptive friction compensation in DC-motor drives, IEEE
Journal of Robotics and Automation 3 (1987).
",
    law: Law {
        axes: ["sliding speed", "force of the guide"],
        start: -1.0,
        with: &[Curve::Points(&[(-1.0, -0.5), (0.0, -0.2), (0.0, 0.6), (1.0, 0.9)])],
        without: &[Curve::GUIDE],
    },
    traits: &[Trait::Dissipative, Trait::DryFriction],
    change: Change::plant::<AsymmetricFriction>(),
};

impl ChangesPlant for AsymmetricFriction {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { level, asymmetry } = self;
        let friction = &mut machine.link_mut(host, &DEFINITION)?.friction;
        friction.forward += level * (1.0 + asymmetry);
        friction.backward += level * (1.0 - asymmetry);
        Ok(())
    }
}
