//! `hardening-stiffness`: a spring that stiffens with its deflection.

use feeler_plant::effects::{HardeningStiffness, Kind};

use super::{Element, Glance, Known};

impl Known for HardeningStiffness {
    const APART: &'static [(Kind, &'static str)] =
        &[(Kind::HertzContact, "press at several levels of force, down to the smallest")];

    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let of_contact = element.contact().map(|contact| (contact.stiffness, glance.force));
        let of_spring = || element.spring().map(|spring| (spring.stiffness_n_per_m, glance.command));
        let Some((stiffness, force)) = of_contact.or_else(of_spring) else { return Vec::new() };
        let like_linear = stiffness.powi(3) / force.max(1e-9).powi(2);
        [0.05, 0.5, 5.0].map(|factor| Self { cubic: factor * like_linear }).to_vec()
    }
}
