//! `force-limit`: a drive with a force limit.

use feeler_plant::effects::ForceLimit;

use super::{Balance, Element, Form, Glance, Known, spread};

impl Known for ForceLimit {
    const BALANCE: Option<Balance<Self>> = Some(Balance::shaped(
        Form::Limit,
        |extent| spread(0.04 * extent.command, 0.98 * extent.command, 40),
        |_, limit| Self { limit },
        |own| (Vec::new(), own.limit),
    ));

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        [0.9, 0.7, 0.5, 0.3, 0.15].map(|share| Self { limit: share * glance.command }).to_vec()
    }
}
