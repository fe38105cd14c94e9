//! `command-delay`: delayed commands.

use feeler_plant::effects::CommandDelay;

use super::{Balance, DELAY_ROWS, Element, Form, Glance, Known, Seen, spread};

/// Trial delays, rows. Readings do not show when a held command arrives between two rows, and jump when the
/// arrival passes a row. Each row is therefore a separate minimum.
const ROWS: [f64; 12] = [0.3, 0.5, 0.8, 1.2, 1.5, 1.8, 2.5, 3.5, 4.5, 5.5, 7.5, 10.5];

impl Known for CommandDelay {
    const BALANCE: Option<Balance<Self>> = Some(Balance::shaped(
        Form::Delay,
        |extent| spread(0.03 * extent.resolved_s, 3.0 * extent.resolved_s, 30),
        |_, delay| Self { delay },
        |own| (Vec::new(), own.delay),
    ));
    const OFF_ROWS: f64 = DELAY_ROWS;

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        ROWS.map(|rows| Self { delay: rows * glance.spacing_s }).to_vec()
    }

    fn is_trivial(self, _: &Element<'_>, seen: Seen) -> bool {
        seen.is_in_time(self.delay)
    }
}
