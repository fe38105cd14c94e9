//! `force-resolution`: quantised forces.

use feeler_plant::effects::ForceResolution;

use super::start::quanta;
use super::{Element, Glance, Known, STEP_SPREAD};

impl Known for ForceResolution {
    /// A step is visible in the readings themselves; residuals determine it far less well.
    const READ_OFF: Option<f64> = Some(STEP_SPREAD);

    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        quanta(element.host, glance).map(|resolution| Self { resolution }).collect()
    }
}
