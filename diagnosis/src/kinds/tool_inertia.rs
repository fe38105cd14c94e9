//! `tool-inertia`: a mass between the force sensor and the contact.

use feeler_plant::effects::ToolInertia;

use super::{Element, Glance, Known};

impl Known for ToolInertia {
    fn starts(_: &Element<'_>, _: &Glance) -> Vec<Self> {
        [0.1, 0.5, 2.0].map(|mass| Self { mass }).to_vec()
    }
}
