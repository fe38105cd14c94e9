//! `force-resolution`: forces in steps.

use feeler_plant::effects::ForceResolution;

use super::start::quanta;
use super::{Element, Glance, Known, STEP_SPREAD};

impl Known for ForceResolution {
    /// A step is read from the values themselves; residuals determine it far less well.
    const READ_OFF: Option<f64> = Some(STEP_SPREAD);

    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        quanta(element.host, glance).map(|resolution| Self { resolution }).collect()
    }
}
