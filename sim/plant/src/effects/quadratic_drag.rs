//! `quadratic-drag`: a resistance that grows with the square of the speed.

use super::prelude::*;

parameters! { QuadraticDrag
    drag: log(Dimension::DRAG, Some(0.0), 50.0, (0.0, 1e9), "resistance over the square of speed"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: QuadraticDrag::KIND,
    name: "quadratic-drag",
    place: Place::Guide,
    order: 180,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: QuadraticDrag::PARAMETERS,
    summary: "a resistance that grows with the square of speed",
    example: "\
[springs.guide.effects.quadratic-drag]
drag = \"20e3 N s2/m2\"
",
    sections: "\
## Model
The guide resists a speed `v` with `drag |v| v`. Small motions about a steady speed are damped by
`2 drag |v|`, small motions about rest not at all.

## Where it comes from
Fans, propellers, fluid that is stirred or pushed through an orifice, oil thrown about by a fast gear. A plate
of 1 m2 in air has about 1 N s2/m2, in oil a thousand times that. A piston that presses oil through an orifice
has `density area^3 / (2 Cd^2 orifice^2)`. For oil, an orifice of 1 % of the piston and pistons of 1 to 100
cm2, that is 1e3 to 1e5 N s2/m2. The example is among them. At 20 mm/s a drag of 5e3 N s2/m2 resists with 2 N,
and the `typical` 50 with 0.02 N.

## How it shows
Fast motion takes more force than `viscous-friction` predicts, slow motion less. A single speed cannot tell
the two apart.

## How it is recognised
Move at several steady speeds: the missing force grows with the square of the speed. Two speeds separate a
line from a parabola. With dry friction beside them you need three.

## Numerical treatment
Forward and backward are modes, so the law is smooth in each, and an extrapolation method integrates it to
machine precision. Linear theory describes motion about rest, where drag has no slope, and leaves it out.

## Source
G. K. Batchelor, An Introduction to Fluid Dynamics, Cambridge University Press (1967): drag at high Reynolds
numbers.
",
    law: LawDrawing {
        axes: ["sliding speed", "resistance of the guide"],
        start: -1.0,
        with: &[Curve::Function(|v| 0.3 * v + 0.6 * v * v.abs())],
        without: &[Curve::GUIDE],
        labels: &[(0.3, 0.7, "drag")],
    },
    traits: &[Trait::Dissipative],
    change: Change::plant::<QuadraticDrag>(),
};

impl ChangesPlant for QuadraticDrag {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        machine.link_mut(host, &DEFINITION)?.drag += self.drag;
        Ok(())
    }
}
