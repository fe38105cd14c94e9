//! `stribeck-friction`: dry friction that falls with speed.

use feeler_plant::effects::{CoulombFriction, EffectUse, Kind, Parameters, StribeckFriction};

use super::start::levels;
use super::{Balance, Element, Extent, Force, Form, Glance, Inner, Known, LEVEL, Seen, spread};

/// Stribeck speed with which a fit starts from Coulomb friction, m/s.
const SPEED_M_PER_S: f64 = 0.01;
/// Relative standard deviations of the level at high speed and of the Stribeck speed. Viscous damping makes
/// both uncertain.
const FALLEN: f64 = 0.18;
const FALL_SPEED: f64 = 0.06;

/// Level at high speed, and what is added at low speed.
pub(super) const SLIDING: &[Force] = &[
    Force::positive(|at| at.direction),
    Force::positive(|at| at.direction * (-(at.speed / at.shape).powi(2)).exp()),
];

/// Trial Stribeck speeds, m/s.
pub(super) fn falls(extent: &Extent) -> Vec<f64> {
    spread(0.02 * extent.speed, 0.6 * extent.speed, 12)
}

impl Known for StribeckFriction {
    const BALANCE: Option<Balance<Self>> = Some(Balance {
        form: Form::Forces(SLIDING),
        shapes: falls,
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

    fn is_trivial(self, element: &Element<'_>, seen: Seen) -> bool {
        let is_believed = |law: &EffectUse| {
            law.definition.kind == Kind::CoulombFriction && element.is_within(law, &[self.coulomb])
        };
        seen.is_stuck_below(self.velocity) && element.laws().iter().any(is_believed)
    }

    fn fractions_off() -> Option<Self> {
        Some(Self { coulomb: FALLEN, static_level: LEVEL, velocity: FALL_SPEED })
    }
}

#[cfg(test)]
mod tests {
    use indexmap::IndexMap;

    use super::*;
    use crate::kinds::element::guide_with_friction;

    /// A higher static level above a believed level is a departure only if a sliding guide reaches it.
    #[test]
    fn truth_a_peak_that_only_stuck_guides_meet_is_no_departure_from_the_believed_level() {
        let (machine, site) = guide_with_friction();
        let tolerance = IndexMap::new();
        let element = Element::at(site, &machine, &tolerance);
        let seen = Seen { speed_m_per_s: 1.0, ..Seen::default() };
        let of = |coulomb, velocity| StribeckFriction { coulomb, static_level: 8.0, velocity };
        assert!(of(1.8, 0.005).is_trivial(&element, seen));
        assert!(!of(1.8, 0.05).is_trivial(&element, seen) && !of(0.5, 0.005).is_trivial(&element, seen));
        assert!(!of(1.8, 0.005).is_trivial(&element.known_exactly(), seen));
    }
}
