//! `actuator-lag`: a lag of the drive.

use feeler_plant::effects::{ActuatorLag, Kind};

use super::start::times;
use super::{Element, Glance, Known};

impl Known for ActuatorLag {
    const APART: &'static [(Kind, &'static str)] = &[(
        Kind::CommandDelay,
        "excite the drive at higher frequencies: a lag takes the amplitude down there, a delay does not",
    )];

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        times(glance).map(|time_constant| Self { time_constant }).to_vec()
    }
}
