//! `force-limit`: a drive that is clipped.

use feeler_plant::effects::ForceLimit;

use super::{Element, Glance, Known};

impl Known for ForceLimit {
    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        [0.9, 0.7, 0.5, 0.3, 0.15].map(|share| Self { limit: share * glance.command }).to_vec()
    }
}
