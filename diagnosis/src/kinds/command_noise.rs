//! `command-noise`: its numbers are not in the records, so no fit can find it.

use feeler_plant::effects::CommandNoise;

use super::{Element, Glance, Known};

impl Known for CommandNoise {
    fn starts(_: &Element<'_>, _: &Glance) -> Vec<Self> {
        Vec::new()
    }
}
