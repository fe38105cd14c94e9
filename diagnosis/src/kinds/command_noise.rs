//! `command-noise`: records do not contain its random values, so no fit can find it.

use feeler_plant::effects::CommandNoise;

use super::{Element, Glance, Known};

impl Known for CommandNoise {
    fn starts(_: &Element<'_>, _: &Glance) -> Vec<Self> {
        Vec::new()
    }
}
