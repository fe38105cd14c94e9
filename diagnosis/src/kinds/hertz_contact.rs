//! `hertz-contact`: a contact that stiffens with force.

use feeler_plant::effects::{ContactStiffness, HertzContact, Kind, Parameters};

use super::{Element, Glance, Inner, Known, Seen};

/// Exponent of smooth spheres.
const EXPONENT: f64 = 1.5;
/// A contact with a smaller exponent is a linear spring.
const LEAST_EXPONENT: f64 = 1.1;

impl Known for HertzContact {
    const CONTAINS: &'static [Inner<Self>] = &[Inner {
        kind: Kind::ContactStiffness,
        embed: |values| Self { exponent: 1.0, stiffness: ContactStiffness::of(values).stiffness },
        nearest: |_| Vec::new(),
    }];
    const APART: &'static [(Kind, &'static str)] =
        &[(Kind::SurfaceOffset, "press at several levels of force: one of them grows stiffer with force")];

    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let Some(contact) = element.contact() else { return Vec::new() };
        // The force equals that of the believed contact at a share of the largest force.
        let (k, force) = (contact.stiffness, glance.force.max(1e-9));
        let at = |share: f64| k * (share * force / k).powf(1.0 - EXPONENT);
        [0.15, 0.4, 1.0].map(|share| Self { exponent: EXPONENT, stiffness: at(share) }).to_vec()
    }

    /// A law with an exponent of one is a linear spring.
    fn is_trivial(self, _: &Element<'_>, _: Seen) -> bool {
        self.exponent < LEAST_EXPONENT
    }
}
