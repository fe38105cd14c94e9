//! `load-friction`: dry friction that grows with contact force and weight.

use feeler_plant::effects::LoadFriction;

use super::{Balance, Element, Force, Glance, Known, Seen};

/// Smallest ratio of friction to load at which a guide is self-locking.
const SELF_LOCKING: f64 = 1.0;
/// Standard deviation of the ratio, as a fraction.
const LOAD: f64 = 0.06;

impl Known for LoadFriction {
    const NEEDS_LOAD: bool = true;
    const BALANCE: Option<Balance<Self>> = Some(Balance::forces(
        &[Force::positive(|at| at.load * at.direction)],
        |of, _| Self { ratio: of[0] },
        |own| (vec![own.ratio], 0.0),
    ));

    fn starts(_: &Element<'_>, _: &Glance) -> Vec<Self> {
        [0.02, 0.08, 0.25].map(|ratio| Self { ratio }).to_vec()
    }

    /// A self-locking guide would hold its load without a drive.
    fn is_trivial(self, _: &Element<'_>, _: Seen) -> bool {
        self.ratio >= SELF_LOCKING
    }

    fn fractions_off() -> Option<Self> {
        Some(Self { ratio: LOAD })
    }
}
