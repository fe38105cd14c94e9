//! Contacts that cannot do what the reference asks, that overlap at the start or are far apart.

use feeler_control::reference::FOLLOWED;
use feeler_engine::{ControllerUse, Scenario};
use feeler_plant::description::{Axis, Contact, ContactLaw, Engagement};
use feeler_problem::Problem;

use super::asked::Asked;
use super::distance::apart_m;
use crate::numbers::with_unit;

/// Largest plausible depth to which a tool sinks into its workpiece, m: a thick foam yields as much.
const SOFT_M: f64 = 0.02;
/// Gaps from this size on are no approach to a workpiece, m.
const FAR_M: f64 = 0.5;

/// A contact that only pushes and has a pull as its reference.
pub(super) fn pull(asked: &Asked<'_>) -> Option<Problem> {
    let Asked { touched, contact, range_n: [least_n, most_n], unit, .. } = *asked;
    let pulls = contact.engagement == Engagement::Unilateral && least_n < 0.0 && most_n <= 0.0;
    pulls.then(|| {
        Problem::new(
            FOLLOWED.of::<ControllerUse>(&asked.found.name),
            format!(
                "the reference asks `{touched}` for a pull of {}, but a contact only pushes",
                with_unit(-least_n, unit)
            ),
            "reverse the sign of the reference",
        )
    })
}

/// A contact that only pushes and sinks in by centimetres under its reference.
pub(super) fn soft(asked: &Asked<'_>) -> Option<Problem> {
    let Asked { scenario, touched, contact, range_n: [_, most_n], unit, .. } = *asked;
    if contact.engagement != Engagement::Unilateral {
        return None;
    }
    let sinks = most_n / contact.stiffness;
    let is_soft = sinks > SOFT_M && is_plain(contact) && scenario.machine.axis == Axis::Translational;
    is_soft.then(|| {
        Problem::new(
            Contact::STIFFNESS.of(touched),
            format!(
                "under the {} asked for, the tool sinks in by {}",
                with_unit(most_n, unit),
                with_unit(sinks, "m")
            ),
            "stiffness is in N/m unless a unit is given: write \"kN/m\" if that is meant",
        )
    })
}

/// Whether a contact pushes with its stiffness times its compression. Another law, or an effect, replaces the
/// stiffness.
fn is_plain(contact: &Contact) -> bool {
    contact.law == ContactLaw::KelvinVoigt && contact.effects.is_empty()
}

/// Contacts whose bodies overlap at the start, or are metres apart.
pub(super) fn gaps(scenario: &Scenario) -> Vec<Problem> {
    let machine = &scenario.machine;
    let is_translational = machine.axis == Axis::Translational;
    let [unit, force] = if is_translational { ["m", "N"] } else { ["rad", "N m"] };
    let mut found = Vec::new();
    for (name, contact) in &machine.contacts {
        let [from, to] = &contact.between;
        let apart = apart_m(machine, contact);
        let key = Contact::GAP.of(name);
        if contact.engagement != Engagement::Unilateral {
            continue;
        }
        if contact.gap_m < 0.0 && apart < 0.0 {
            let pushes = is_plain(contact).then(|| {
                format!(
                    ": the contact begins with a push of {}",
                    with_unit(contact.stiffness * -apart, force)
                )
            });
            found.push(Problem::new(
                key,
                format!(
                    "`{from}` starts {} inside `{to}`{}",
                    with_unit(-apart, unit),
                    pushes.unwrap_or_default()
                ),
                "a positive gap keeps them apart",
            ));
        } else if is_translational && contact.gap_m >= FAR_M && apart >= FAR_M {
            found.push(Problem::new(
                key,
                format!(
                    "`{from}` starts {} from `{to}`, farther than a tool approaches",
                    with_unit(apart, unit)
                ),
                "gap is in m unless a unit is given: write \"mm\" if that is meant",
            ));
        }
    }
    found
}
