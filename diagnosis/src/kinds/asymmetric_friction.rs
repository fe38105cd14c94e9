//! `asymmetric-friction`: dry friction that depends on the direction.

use feeler_plant::effects::{AsymmetricFriction, ConstantLoad, CoulombFriction, Kind, Parameters};

use super::start::levels;
use super::{Balance, Element, Force, Glance, Inner, Known, Seen, SumOf};

/// Smaller asymmetries count as zero.
const LEAST_ASYMMETRY: f64 = 0.02;

impl Known for AsymmetricFriction {
    const BALANCE: Option<Balance<Self>> = Some(Balance::forces(
        // Presliding leads from one level to the other, without a stop at zero.
        &[Force::positive(|at| 0.5 * (at.direction + 1.0)), Force::positive(|at| 0.5 * (at.direction - 1.0))],
        |of, _| {
            let level = 0.5 * (of[0] + of[1]);
            Self { level, asymmetry: if level > 0.0 { 0.5 * (of[0] - of[1]) / level } else { 0.0 } }
        },
        |own| (vec![own.level * (1.0 + own.asymmetry), own.level * (1.0 - own.asymmetry)], 0.0),
    ));
    const CONTAINS: &'static [Inner<Self>] = &[Inner {
        kind: Kind::CoulombFriction,
        embed: |values| Self { level: CoulombFriction::of(values).level, asymmetry: 0.0 },
        nearest: |outer| vec![vec![outer.level]],
    }];
    const SUM_OF: Option<SumOf<Self>> = Some(SumOf {
        parts: [Kind::CoulombFriction, Kind::ConstantLoad],
        split: |own| [vec![own.level], vec![-own.level * own.asymmetry]],
        merge: |[friction, load]| {
            let (level, force) = (CoulombFriction::of(friction).level, ConstantLoad::of(load).force);
            Self { level, asymmetry: -force / level }
        },
    });
    const APART: &'static [(Kind, &'static str)] = &[(
        Kind::ConstantLoad,
        "take cables and counterweights off, or turn an inclined axis end for end, and record again: only \
         a load changes; no command separates the two, since both resist with the same force in either \
         direction",
    )];

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let at = |level: f64| [-0.3, 0.3].map(|asymmetry| Self { level, asymmetry });
        levels(glance.command).into_iter().flat_map(at).collect()
    }

    /// Nearly equal levels are one level.
    fn is_trivial(self, _: &Element<'_>, _: Seen) -> bool {
        self.asymmetry.abs() < LEAST_ASYMMETRY
    }
}
