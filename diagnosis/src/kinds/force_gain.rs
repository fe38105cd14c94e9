//! `force-gain`: a force sensor that reads too much or too little.

use feeler_plant::description::Sensor;
use feeler_plant::effects::ForceGain;

use super::start::{GAINS, off};
use super::{Element, Glance, Known, Seen};
use crate::tolerance::FRACTION;

impl Known for ForceGain {
    fn starts(_: &Element<'_>, _: &Glance) -> Vec<Self> {
        GAINS.map(|gain| Self { gain }).to_vec()
    }

    fn is_trivial(self, element: &Element<'_>, _: Seen) -> bool {
        off(self.gain, 1.0) <= element.tolerance(&Sensor::GAIN.key, FRACTION)
    }
}
