//! `stribeck-friction`: dry friction whose level falls from static to Coulomb with speed.

use super::prelude::*;

parameters! { StribeckFriction
    coulomb: log(Dimension::FORCE, Some(0.0), 10.0, (0.0, 1e6), "level far above the Stribeck speed"),
    static_level as "static": log(
        Dimension::FORCE, Some(0.0), 15.0, (0.0, 1e6), "level at rest, not below `coulomb`"
    ),
    velocity: log(
        Dimension::VELOCITY, None, 0.01, (ABOVE_ZERO, 1e3), "Stribeck speed, over which the level falls"
    ),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: StribeckFriction::KIND,
    name: "stribeck-friction",
    place: Place::Guide,
    order: 150,
    hosts: &[HostKind::Spring],
    site: "",
    parameters: StribeckFriction::PARAMETERS,
    summary: "dry friction whose level falls from static to Coulomb with speed",
    example: "\
[springs.guide.effects.stribeck-friction]
coulomb = \"4 N\"
static = \"7 N\"
velocity = \"5 mm/s\"
",
    sections: "\
## Model
Sliding at speed `v`, the guide resists with
`(coulomb + (static - coulomb) exp(-(v / velocity)^2)) sign(v)`; at rest it takes any value up to `static`.

## Where it comes from
Lubricated guides and gears: at low speed the film is too thin to keep the surfaces apart.

## How it shows
The breakaway force exceeds the force needed to keep moving, so slow motion is a sequence of sticks and jumps.
A force loop with an integrator hunts if the jump overshoots: with a large, steep fall and a fast integrator.
The example does not. The law falls most steeply at `velocity / sqrt(2)`. Sliding is smooth at every speed
only if guide and controller damp by more than `0.86 (static - coulomb) / velocity`. Above a few times
`velocity` it is `coulomb-friction`, and only slow motion or reversals separate them. A falling level looks
like negative `viscous-friction` over a narrow range of speeds.

## How it is recognised
Plot the missing force against velocity: it falls from the breakaway level to a plateau. Steady motion at
several slow speeds shows the fall.

## Numerical treatment
Sticking is exact. While the guide slides, an extrapolation method integrates the falling law to machine
precision. Stick and slip are events. Linear theory takes friction as sliding one way.

## Source
B. Armstrong-Hélouvry, P. Dupont and C. Canudas de Wit, A survey of models, analysis tools and compensation
methods for the control of machines with friction, Automatica 30 (1994).
",
    law: LawDrawing {
        axes: ["sliding speed", "resistance of the guide"],
        start: -1.0,
        with: &[Curve::Function(|v| 0.3 * v + (0.3 + 0.4 * (-(v / 0.2).powi(2)).exp()) * v.signum())],
        without: &[Curve::GUIDE],
        labels: &[(-0.42, 0.7, "static"), (0.5, 0.75, "coulomb"), (0.05, -0.3, "velocity")],
    },
    traits: &[Trait::Dissipative, Trait::DryFriction],
    change: Change::plant::<StribeckFriction>(),
};

/// Level at rest less the level far above the Stribeck speed, N.
///
/// # Errors
/// [`EffectError::Value`] if the level at rest is lower.
pub(super) fn excess(coulomb: f64, static_level: f64) -> Result<f64, EffectError> {
    let excess = static_level - coulomb;
    if excess < 0.0 {
        return Err(EffectError::Value {
            parameter: "static",
            value: static_level,
            reason: "the level at rest is below `coulomb`",
            remedy: "raise it to `coulomb` or above",
        });
    }
    Ok(excess)
}

impl ChangesPlant for StribeckFriction {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { coulomb, static_level, velocity } = self;
        let friction = &mut machine.link_mut(host, &DEFINITION)?.friction;
        let excess = excess(coulomb, static_level)?;
        friction.forward += coulomb;
        friction.backward += coulomb;
        if excess > 0.0 {
            friction.stribeck_excess += excess;
            friction.stribeck_velocity = velocity;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture::{self, TRANSMISSION};

    #[test]
    fn truth_excess_is_static_less_coulomb() {
        let mut machine = fixture::flexible();
        DEFINITION.apply(&mut machine, TRANSMISSION, &[10.0, 16.0, 0.02]).unwrap();
        let friction = machine.links[1].friction;
        let expected = crate::assembly::Friction {
            forward: 10.0,
            backward: 10.0,
            stribeck_excess: 6.0,
            stribeck_velocity: 0.02,
            load_ratio: 0.0,
            over: None,
        };
        assert_eq!(friction, expected);
    }

    #[test]
    fn prop_a_level_that_rises_with_speed_is_refused() {
        let mut machine = fixture::flexible();
        let error = DEFINITION.apply(&mut machine, TRANSMISSION, &[10.0, 9.0, 0.02]).unwrap_err();
        assert!(matches!(error, EffectError::Value { parameter: "static", .. }));
        assert_eq!(machine, fixture::flexible());
    }
}
