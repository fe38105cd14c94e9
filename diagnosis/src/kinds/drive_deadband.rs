//! `drive-deadband`: small commands that do nothing.

use feeler_plant::effects::DriveDeadband;

use super::start::levels;
use super::{Element, Glance, Known};

impl Known for DriveDeadband {
    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        levels(glance.command).map(|width| Self { width }).to_vec()
    }
}
