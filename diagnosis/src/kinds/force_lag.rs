//! `force-lag`: a force sensor that lags.

use feeler_plant::effects::ForceLag;

use super::start::times;
use super::{Element, Glance, Known};

impl Known for ForceLag {
    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        times(glance).map(|time_constant| Self { time_constant }).to_vec()
    }
}
