//! `asymmetric-friction`: dry friction with one level per direction.

use super::prelude::*;

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
    order: 200,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: AsymmetricFriction::PARAMETERS,
    summary: "dry friction of two levels, one for each direction",
    example: "\
[springs.guide.effects.asymmetric-friction]
level = \"6 N\"
asymmetry = 0.5
",
    sections: "\
## Model
Sliding forward, the guide resists with `level (1 + asymmetry)`, backward with `level (1 - asymmetry)`. At
rest it holds up to the level of the direction in which it would start. Forward means that the second body of
the spring moves in the positive direction relative to the first.

## Where it comes from
Lip seals, worn or tilted guides, gears whose two flanks differ.

## How it shows
The missing force is a step at every reversal of the velocity, and it is larger on one side.
`coulomb-friction` of the mean level with a `constant-load` of `-level asymmetry` is the same force on the
axis, moving and at rest. No record of commands and motion separates the two. Where the axis only ever moves
one way, either of them alone looks the same, too.

## How it is recognised
Compare slow strokes in both directions: the forces against the motion differ by `2 level asymmetry`, at every
speed. Friction with a load does the same. To separate them, take cables and counterweights off, or turn an
inclined axis end for end. The pull of the weight along the axis then changes sign, the asymmetry does not.

## Numerical treatment
As dry friction with one level: modes for sliding either way and for sticking, with events between them.
Linear theory takes friction as sliding one way.

## Source
C. Canudas de Wit, K. J. Åström and K. Braun, Adaptive friction compensation in DC-motor drives, IEEE
Journal of Robotics and Automation 3 (1987).
",
    law: LawDrawing {
        axes: ["sliding speed", "resistance of the guide"],
        start: -1.0,
        with: &[Curve::Points(&[(-1.0, -0.5), (0.0, -0.2), (0.0, 0.6), (1.0, 0.9)])],
        without: &[Curve::GUIDE],
        labels: &[(0.05, 0.4, "level (1 + asymmetry)"), (-1.0, -0.75, "level (1 - asymmetry)")],
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
