//! `force-limit`: a drive with a force limit.

use feeler_plant::effects::ForceLimit;

use super::{Balance, Element, Form, Glance, Known, spread};

/// A limit below this share of the largest command is tried only if it clips less than half of the rows.
/// Otherwise it leaves little of a command to explain.
const LEAST: f64 = 0.3;

impl Known for ForceLimit {
    const BALANCE: Option<Balance<Self>> = Some(Balance::shaped(
        Form::Limit,
        |extent| {
            let least = (LEAST * extent.command).min(extent.usual_command);
            spread(least, 0.98 * extent.command, 40)
        },
        |_, limit| Self { limit },
        |own| (Vec::new(), own.limit),
    ));

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        [0.9, 0.7, 0.5, 0.3, 0.15].map(|share| Self { limit: share * glance.command }).to_vec()
    }
}
