//! `lugre-friction`: friction of bristles that deflect before they slide.

use std::f64::consts::TAU;

use feeler_plant::effects::{CoulombFriction, Kind, LugreFriction, Parameters, StribeckFriction};

use super::start::levels;
use super::stribeck_friction::{SLIDING, falls};
use super::{Balance, Element, Form, Glance, Inner, Known, Seen, nearest};

/// Deflection of bristles that practically represent Coulomb friction, m.
const SHORT_M: f64 = 1e-5;
/// Ratio of damping to stiffness of such bristles, s.
const SETTLES_S: f64 = 1e-3;
/// Initial frequencies, Hz, of the moving mass on its bristles, and the damping ratio there.
const FREQUENCIES_HZ: [f64; 2] = [25.0, 90.0];
const RATIO: f64 = 0.5;
/// Share of the largest speed over which the level falls.
const FALLS: f64 = 0.05;

/// Bristles so stiff that they practically represent dry friction with these levels.
fn stiff(coulomb: f64, static_level: f64, velocity: f64) -> LugreFriction {
    let stiffness = static_level / SHORT_M;
    LugreFriction { stiffness, damping: SETTLES_S * stiffness, coulomb, static_level, velocity }
}

impl Known for LugreFriction {
    /// The balance of Stribeck friction. How bristles bend is the presliding of every guide there.
    const BALANCE: Option<Balance<Self>> = Some(Balance {
        form: Form::Forces(SLIDING),
        shapes: falls,
        values: |of, velocity| stiff(of[0], of[0] + of[1], velocity),
        coefficients: |own| (vec![own.coulomb, (own.static_level - own.coulomb).max(0.0)], own.velocity),
    });
    const CONTAINS: &'static [Inner<Self>] = &[
        Inner {
            kind: Kind::CoulombFriction,
            embed: |values| {
                let CoulombFriction { level } = CoulombFriction::of(values);
                stiff(level, level, 0.01)
            },
            nearest: |outer| vec![vec![outer.coulomb], vec![outer.static_level]],
        },
        Inner {
            kind: Kind::StribeckFriction,
            embed: |values| {
                let StribeckFriction { coulomb, static_level, velocity } = StribeckFriction::of(values);
                stiff(coulomb, static_level, velocity)
            },
            nearest: |outer| vec![vec![outer.coulomb, outer.static_level, outer.velocity]],
        },
    ];
    const APART: &'static [(Kind, &'static str)] = &[
        (
            Kind::StribeckFriction,
            "push back and forth with less than the level and record finely: only bristles yield like a \
             spring",
        ),
        (
            Kind::CoulombFriction,
            "push back and forth with less than the level and record finely: only bristles yield like a \
             spring",
        ),
    ];

    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let Some(assembly) = element.assembly() else { return Vec::new() };
        let mass: f64 = assembly.nodes.iter().map(|node| node.mass_kg).filter(|mass| mass.is_finite()).sum();
        let at = |coulomb: f64| {
            FREQUENCIES_HZ.map(|frequency| {
                let omega = TAU * frequency;
                Self {
                    stiffness: mass * omega * omega,
                    damping: 2.0 * RATIO * mass * omega,
                    coulomb,
                    static_level: 1.3 * coulomb,
                    velocity: FALLS * glance.speed.max(1e-9),
                }
            })
        };
        levels(glance.command).into_iter().flat_map(at).collect()
    }

    /// Every guide has presliding, which fits allow for. Bristles whose levels lie within the tolerance of a
    /// believed law are therefore not a finding. Neither is a static level that no sliding guide reaches.
    fn is_trivial(self, element: &Element<'_>, seen: Seen) -> bool {
        let mut shown = self;
        if seen.is_stuck_below(self.velocity) {
            shown.static_level = self.coulomb;
        }
        element.laws().iter().any(|law| {
            let own = nearest(Kind::LugreFriction, law.definition.kind, &shown.values());
            !own.is_empty() && own.iter().all(|own| element.is_within(law, own))
        })
    }
}

#[cfg(test)]
mod tests {
    use indexmap::IndexMap;

    use super::*;
    use crate::kinds::element::guide_with_friction;

    #[test]
    fn truth_bristles_at_the_believed_level_are_no_departure() {
        let (machine, site) = guide_with_friction();
        let tolerance = IndexMap::new();
        let element = Element::at(site, &machine, &tolerance);
        let seen = Seen::default();
        let of = |coulomb, static_level| LugreFriction { coulomb, static_level, ..stiff(2.0, 2.0, 0.1) };
        // The level is believed within a factor of two.
        assert!(of(1.8, 2.1).is_trivial(&element, seen));
        assert!(!of(1.8, 4.5).is_trivial(&element, seen) && !of(0.9, 2.1).is_trivial(&element, seen));
        assert!(!of(1.8, 2.1).is_trivial(&element.known_exactly(), seen));
        // The static level has faded at 0.1 m/s. If all motion is faster, no record shows it.
        let seen = Seen { speed_m_per_s: 20.0, ..seen };
        assert!(of(1.8, 400.0).is_trivial(&element, seen) && !of(0.9, 2.1).is_trivial(&element, seen));
    }
}
