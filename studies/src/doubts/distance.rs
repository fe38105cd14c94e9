//! Distances at the start.

use feeler_plant::description::{Contact, Machine};

/// Distance between the bodies of a contact at the start, negative if they overlap.
pub(super) fn apart_m(machine: &Machine, contact: &Contact) -> f64 {
    let starts_at = |name: &String| machine.bodies.get(name).map_or(0.0, |body| body.position_m);
    let [from, to] = &contact.between;
    contact.gap_m - (starts_at(from) - starts_at(to))
}
