//! `constant-load`: weight, cables, counterweights.

use feeler_plant::effects::ConstantLoad;

use super::{Element, Glance, Known};

impl Known for ConstantLoad {
    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        [-0.01, -0.1, -0.5, 0.01, 0.1, 0.5].map(|share| Self { force: share * glance.command }).to_vec()
    }
}
