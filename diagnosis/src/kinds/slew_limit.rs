//! `slew-limit`: a drive with a limited rate of force.

use feeler_plant::effects::SlewLimit;

use super::{Element, Glance, Known};

impl Known for SlewLimit {
    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let fastest = glance.command_change / glance.spacing_s;
        [0.5, 0.2, 0.08, 0.03].map(|share| Self { rate: share * fastest }).to_vec()
    }
}
