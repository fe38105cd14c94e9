//! `force-bias`: a force sensor with an offset.

use feeler_plant::effects::ForceBias;

use super::{Element, Glance, Known};

impl Known for ForceBias {
    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        [-1.0, 1.0].map(|sign| Self { bias: sign * 0.03 * glance.force.max(1e-9) }).to_vec()
    }
}
