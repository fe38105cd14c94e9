//! `constant-load`: weight, cables, counterweights.

use feeler_plant::effects::ConstantLoad;

use super::{Balance, Element, Force, Glance, Known};

impl Known for ConstantLoad {
    /// The load acts along the axis, so a negative value resists forward motion.
    const BALANCE: Option<Balance<Self>> = Some(Balance::forces(
        &[Force::signed(|_| -1.0)],
        |of, _| Self { force: of[0] },
        |own| (vec![own.force], 0.0),
    ));

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        [-0.01, -0.1, -0.5, 0.01, 0.1, 0.5].map(|share| Self { force: share * glance.command }).to_vec()
    }
}
