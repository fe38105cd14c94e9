//! `surface-offset`: a surface that is nearer or farther away than believed.

use feeler_plant::description::Contact;
use feeler_plant::effects::{Host, Parameters, SurfaceOffset};

use super::{Element, Glance, Known, Seen};
use crate::tolerance::GAP;

impl Known for SurfaceOffset {
    /// The tool feels no force from a surface beyond its stroke, so a fit cannot find the surface. The start
    /// is therefore read from the records.
    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let read = glance.surfaces.iter().filter(|(contact, _)| element.host == Host::Contact(*contact));
        [-2.0, -0.6, -0.2, 0.2, 0.6, 2.0]
            .into_iter()
            .map(|factor| factor * Self::typical().offset)
            .chain(read.map(|(_, offset)| *offset))
            .map(|offset| Self { offset })
            .collect()
    }

    fn is_trivial(self, element: &Element<'_>, _: Seen) -> bool {
        let gap_m = element.contact().map_or(0.0, |contact| contact.gap_m);
        self.offset.abs() <= element.tolerance(&Contact::GAP.key, GAP) * gap_m.abs()
    }
}
