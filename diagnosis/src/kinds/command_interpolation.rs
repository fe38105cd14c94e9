//! `command-interpolation`: records show only a delay or lag, which other effects cause too, so it is not
//! tried.

use feeler_plant::effects::CommandInterpolation;

use super::{Element, Glance, Known};

impl Known for CommandInterpolation {
    fn starts(_: &Element<'_>, _: &Glance) -> Vec<Self> {
        Vec::new()
    }
}
