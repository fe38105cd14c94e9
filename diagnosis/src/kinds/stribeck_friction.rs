//! `stribeck-friction`: dry friction that falls with speed.

use feeler_plant::effects::{CoulombFriction, Kind, Parameters, StribeckFriction};

use super::start::levels;
use super::{Balance, Element, Force, Form, Glance, Inner, Known, LEVEL, spread};

/// Speed over which it falls when its fit starts from Coulomb friction, m/s.
const SPEED_M_PER_S: f64 = 0.01;
/// Standard deviation of the level at high speed, and of the Stribeck speed, as fractions: viscous damping
/// hides it.
const FALLEN: f64 = 0.18;
const FALL_SPEED: f64 = 0.06;

impl Known for StribeckFriction {
    const BALANCE: Option<Balance<Self>> = Some(Balance {
        form: Form::Forces(&[
            Force::positive(|at| at.direction),
            Force::positive(|at| at.direction * (-(at.speed / at.shape).powi(2)).exp()),
        ]),
        shapes: |extent| spread(0.02 * extent.speed, 0.6 * extent.speed, 12),
        values: |of, velocity| Self { coulomb: of[0], static_level: of[0] + of[1], velocity },
        coefficients: |own| (vec![own.coulomb, (own.static_level - own.coulomb).max(0.0)], own.velocity),
    });
    const CONTAINS: &'static [Inner<Self>] = &[Inner {
        kind: Kind::CoulombFriction,
        embed: |values| {
            let CoulombFriction { level } = CoulombFriction::of(values);
            Self { coulomb: level, static_level: level, velocity: SPEED_M_PER_S }
        },
        nearest: |outer| vec![vec![outer.coulomb], vec![outer.static_level]],
    }];

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let speeds = [0.01, 0.05, 0.2].map(|share| share * glance.speed);
        let at =
            |coulomb: f64| speeds.map(|velocity| Self { coulomb, static_level: 1.8 * coulomb, velocity });
        levels(glance.command).into_iter().flat_map(at).collect()
    }

    fn fractions_off() -> Option<Self> {
        Some(Self { coulomb: FALLEN, static_level: LEVEL, velocity: FALL_SPEED })
    }
}
