//! `contact-damping`: a contact with another damping than believed.

use feeler_plant::description::Contact;
use feeler_plant::effects::ContactDamping;

use super::{Element, Glance, Known, Seen};
use crate::tolerance::DAMPING;

impl Known for ContactDamping {
    fn starts(element: &Element<'_>, _: &Glance) -> Vec<Self> {
        let Some(contact) = element.contact() else { return Vec::new() };
        let believed = contact.damping_n_s_per_m.max(1.0);
        [0.2, 4.0, 12.0].map(|factor| Self { damping: factor * believed }).to_vec()
    }

    fn is_trivial(self, element: &Element<'_>, _: Seen) -> bool {
        let believed = element.contact().map_or(0.0, |contact| contact.damping_n_s_per_m);
        believed > 0.0
            && (self.damping / believed).ln().abs()
                <= element.tolerance(&Contact::DAMPING.key, DAMPING).ln_1p()
    }
}
