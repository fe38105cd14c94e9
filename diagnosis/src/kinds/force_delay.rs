//! `force-delay`: delayed force readings.

use feeler_plant::effects::{ForceDelay, Kind};

use super::start::times;
use super::{DELAY_ROWS, Element, Glance, Known};

impl Known for ForceDelay {
    const OFF_ROWS: f64 = DELAY_ROWS;
    const APART: &'static [(Kind, &'static str)] = &[(
        Kind::ForceLag,
        "tap the tool with the drive off and record force and acceleration: a lag rounds the blow, a delay \
         only shifts it",
    )];

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        times(glance).map(|delay| Self { delay }).to_vec()
    }
}
