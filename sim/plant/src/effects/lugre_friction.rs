//! `lugre-friction`: friction of bristles that bend before they slide.

use super::prelude::*;
use super::stribeck_friction::excess;
use crate::assembly::Bristle;

parameters! { LugreFriction
    stiffness: log(Dimension::STIFFNESS, None, 1e6, (ABOVE_ZERO, 1e12), "stiffness of the bristles"),
    damping: log(Dimension::DAMPING, None, 1e3, (0.0, 1e9), "damping of the bristles"),
    coulomb: log(Dimension::FORCE, Some(0.0), 10.0, (0.0, 1e6), "level far above the Stribeck speed"),
    static_level as "static": log(
        Dimension::FORCE, Some(0.0), 15.0, (0.0, 1e6), "level at rest, not below `coulomb`"
    ),
    velocity: log(
        Dimension::VELOCITY, None, 0.01, (ABOVE_ZERO, 1e3), "Stribeck speed, over which the level falls"
    ),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: LugreFriction::KIND,
    name: "lugre-friction",
    place: Place::Guide,
    order: 210,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: LugreFriction::PARAMETERS,
    summary: "friction of bristles that bend before they slide",
    example: "\
[springs.guide.effects.lugre-friction]
stiffness = \"500 kN/m\"
damping = \"2 kN s/m\"
coulomb = \"4 N\"
static = \"7 N\"
velocity = \"5 mm/s\"
",
    sections: "\
## Model
Bristles bend by `z` under the sliding speed `v` and straighten as they slip:
`z' = v - stiffness |v| / g(v) z` with `g(v) = coulomb + (static - coulomb) exp(-(v / velocity)^2)`. The guide
resists with `stiffness z + damping z'`; its own damping is the viscous part. Sliding steadily, it resists
with `g(v)`. At rest it yields as a spring: the bristles bend by up to `static / stiffness`, 14 um in the
example. `damping` is usually `sqrt(stiffness m)` to twice that, `m` the sliding mass: 3 to 6 kN s/m for the
`typical` stiffness and 10 kg.

## Where it comes from
Lubricated guides, bearings, seals and gears: asperities bend by micrometres before they slide.

## How it shows
Just after a reversal the force rises as that of a spring, and over a small cycle it follows a hysteresis
loop. A slow drive sticks and slips. The faster the force rises, the smaller the breakaway force. Under a load
and a vibration that together stay below `coulomb` it creeps on, more than real guides do. In impacts the
damping of the bristles acts like a large viscous friction. The law is passive only if the guide's own damping
exceeds `damping (static - coulomb) / coulomb` (Barabanov and Ortega); the example is not. Records with an
encoder step above `static / stiffness` cannot tell it from `stribeck-friction`, nor, well above `velocity`,
from `coulomb-friction`.

## How it is recognised
Move the axis by micrometres about one point, with an encoder that resolves a tenth of `static / stiffness`.
Force against position is then a loop with elastic flanks. Coarser records see only its sliding level.

## Numerical treatment
The bending of the bristles is one more state. Forward and backward are modes, and an extrapolation method
integrates each to machine precision (a relative error of 4e-14). Its steps shorten as
`coulomb / (stiffness |v|)`, so that stiff bristles at high speed cost time. The energy balance counts what
bent bristles store. Linear theory takes the bristles at rest, as a spring and a damper. Coulomb friction
drops out of it, so the margins differ.

## Source
C. Canudas de Wit, H. Olsson, K. J. Åström and P. Lischinsky, A new model for control of systems with
friction, IEEE Transactions on Automatic Control 40 (1995). On passivity, N. Barabanov and R. Ortega in the
same journal, volume 45 (2000).
",
    law: LawDrawing {
        axes: ["position, slowly back and forth", "resistance of the guide"],
        start: -1.0,
        with: &[
            Curve::Function(|x| 0.7 - 1.4 * (-(x + 1.0) / 0.3).exp()),
            Curve::Function(|x| -0.7 + 1.4 * ((x - 1.0) / 0.3).exp()),
        ],
        without: &[],
        labels: &[(0.2, 0.85, "static: forward"), (-0.95, -0.9, "backward"), (-0.7, -0.15, "stiffness")],
    },
    traits: &[Trait::DryFriction, Trait::Bristles],
    change: Change::plant::<LugreFriction>(),
};

impl ChangesPlant for LugreFriction {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { stiffness, damping, coulomb, static_level, velocity } = self;
        let link = machine.link_mut(host, &DEFINITION)?;
        let excess = excess(coulomb, static_level)?;
        if coulomb <= 0.0 && excess > 0.0 {
            return Err(EffectError::Value {
                parameter: "coulomb",
                value: coulomb,
                reason: "bristles without a level slip infinitely fast",
                remedy: "give the level far above the Stribeck speed",
            });
        }
        if coulomb > 0.0 {
            link.bristle = Some(Bristle { stiffness, damping, coulomb, excess, velocity });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture::{self, GUIDE};

    #[test]
    fn truth_bristles_that_slide_steadily_carry_the_level() {
        let mut machine = fixture::flexible();
        DEFINITION.apply(&mut machine, GUIDE, &[1e5, 300.0, 1.0, 1.5, 1e-3]).unwrap();
        let bristle = machine.links[0].bristle.unwrap();
        for v in [1e-4_f64, 1e-3, 0.1] {
            let level = 1.0 + 0.5 * (-(v / 1e-3).powi(2)).exp();
            // With a deflection of level over stiffness, they straighten as fast as they bend.
            assert!((bristle.slip(v, level / 1e5) / v - 1.0).abs() < 1e-14, "{v}");
        }
    }

    #[test]
    fn prop_levels_that_make_no_law_are_refused() {
        for (values, wrong) in
            [([1e5, 3e2, 2.0, 1.0, 1e-3], "static"), ([1e5, 3e2, 0.0, 1.0, 1e-3], "coulomb")]
        {
            let mut machine = fixture::flexible();
            let error = DEFINITION.apply(&mut machine, GUIDE, &values).unwrap_err();
            assert!(matches!(error, EffectError::Value { parameter, .. } if parameter == wrong));
            assert_eq!(machine, fixture::flexible());
        }
    }
}
