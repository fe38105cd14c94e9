//! `directional-damping`: viscous friction that depends on the direction.

use feeler_plant::effects::{DirectionalDamping, Kind, Parameters, ViscousFriction};

use super::{Balance, Element, Force, Glance, Inner, Known, Seen};

/// Smaller asymmetries count as zero.
const LEAST_ASYMMETRY: f64 = 0.05;

impl Known for DirectionalDamping {
    const BALANCE: Option<Balance<Self>> = Some(Balance::forces(
        &[Force::positive(|at| at.speed.max(0.0)), Force::positive(|at| at.speed.min(0.0))],
        |of, _| {
            let damping = 0.5 * (of[0] + of[1]);
            Self { damping, asymmetry: if damping > 0.0 { 0.5 * (of[0] - of[1]) / damping } else { 0.0 } }
        },
        |own| (vec![own.damping * (1.0 + own.asymmetry), own.damping * (1.0 - own.asymmetry)], 0.0),
    ));
    const CONTAINS: &'static [Inner<Self>] = &[Inner {
        kind: Kind::ViscousFriction,
        embed: |values| Self { damping: ViscousFriction::of(values).damping, asymmetry: 0.0 },
        nearest: |outer| vec![vec![outer.damping]],
    }];
    const APART: &'static [(Kind, &'static str)] = &[(
        Kind::AsymmetricFriction,
        "repeat the strokes at a third of the speed: only one difference between the directions shrinks \
         with it",
    )];

    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let believed = element.spring().map_or(0.0, |spring| spring.damping_n_s_per_m);
        let own = believed.max(0.1 * glance.command / glance.speed.max(1e-9));
        let at = |share: f64| [-0.5, 0.5].map(|asymmetry| Self { damping: share * own, asymmetry });
        [0.02, 0.3, 2.0].into_iter().flat_map(at).collect()
    }

    fn is_trivial(self, _: &Element<'_>, _: Seen) -> bool {
        self.asymmetry.abs() < LEAST_ASYMMETRY
    }
}
