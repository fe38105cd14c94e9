//! `drive-deadband`: a drive that ignores small commands.

use feeler_plant::effects::DriveDeadband;

use super::start::levels;
use super::{Balance, Element, Form, Glance, Known};

/// Share of the largest command that is the smallest width of note.
const OF_NOTE: f64 = 0.1;

impl Known for DriveDeadband {
    const BALANCE: Option<Balance<Self>> = Some(Balance::shaped(
        Form::Deadband,
        |_| vec![0.0],
        |of, _| Self { width: of[0] },
        |own| (vec![own.width], 0.0),
    ));

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        levels(glance.asked).map(|width| Self { width }).to_vec()
    }

    /// While the drive pushes the way it moves, dry friction is larger by the width.
    fn behind_calibration(largest_command: f64) -> Option<(Self, &'static str)> {
        Some((Self { width: OF_NOTE * largest_command }, "faster motion, in which the drive brakes"))
    }
}
