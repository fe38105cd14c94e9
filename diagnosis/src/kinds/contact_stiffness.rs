//! `contact-stiffness`: a contact with another stiffness than believed.

use feeler_plant::description::Contact;
use feeler_plant::effects::{ContactStiffness, Kind};

use super::start::off;
use super::{Element, Glance, Known, Seen};
use crate::tolerance::FRACTION;

impl Known for ContactStiffness {
    const APART: &'static [(Kind, &'static str)] =
        &[(Kind::ForceGain, "hang a known weight on the force sensor")];

    fn starts(element: &Element<'_>, _: &Glance) -> Vec<Self> {
        let Some(contact) = element.contact() else { return Vec::new() };
        [0.4, 0.7, 1.4, 2.5].map(|factor| Self { stiffness: factor * contact.stiffness }).to_vec()
    }

    fn is_trivial(self, element: &Element<'_>, _: Seen) -> bool {
        let within = element.tolerance(&Contact::STIFFNESS.key, FRACTION);
        element.contact().is_some_and(|contact| off(self.stiffness, contact.stiffness) <= within)
    }
}
