//! `load-friction`: dry friction that grows with the contact force.

use feeler_plant::effects::LoadFriction;

use super::{Element, Glance, Known, Seen};

/// Smallest ratio of friction to contact force at which a guide is self-locking.
const SELF_LOCKING: f64 = 1.0;
/// Standard deviation of the ratio, as a fraction.
const LOAD: f64 = 0.06;

impl Known for LoadFriction {
    const NEEDS_CONTACT: bool = true;

    fn starts(_: &Element<'_>, _: &Glance) -> Vec<Self> {
        [0.02, 0.08, 0.25].map(|ratio| Self { ratio }).to_vec()
    }

    /// A self-locking guide would keep the tool in contact without a drive.
    fn is_trivial(self, _: &Element<'_>, _: Seen) -> bool {
        self.ratio >= SELF_LOCKING
    }

    fn fractions_off() -> Option<Self> {
        Some(Self { ratio: LOAD })
    }
}
