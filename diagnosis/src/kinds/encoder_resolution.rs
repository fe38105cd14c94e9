//! `encoder-resolution`: quantised positions.

use feeler_plant::effects::EncoderResolution;

use super::start::quanta;
use super::{Element, Glance, Known, STEP_SPREAD};

impl Known for EncoderResolution {
    /// A step is visible in the readings themselves; residuals determine it far less well.
    const READ_OFF: Option<f64> = Some(STEP_SPREAD);

    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        quanta(element.host, glance).map(|resolution| Self { resolution }).collect()
    }
}
