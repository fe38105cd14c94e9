//! The force at which a machine is linearised.

use feeler_analysis::ContactView;
use feeler_engine::Scenario;
use feeler_studies::operating_point::{Dependence, force_dependence, wanted_force_n};

use crate::arguments::Analyze;
use crate::numbers::with_unit;
use crate::terminal::failure::BadInput;
use crate::units::Units;

/// The view of the contacts, and a note on the force at which they are linearised.
pub(super) fn contact_view(
    arguments: &Analyze,
    scenario: &Scenario,
) -> crate::Result<(ContactView, Option<String>)> {
    if let Some(preload_n) = arguments.preload {
        if !(preload_n.is_finite() && preload_n > 0.0) {
            return Err(BadInput::error(
                format!("--preload must be a force above zero (got {preload_n} N)"),
                "give a force in N, as in --preload 30",
            ));
        }
        return Ok((ContactView::Pressed { preload_n }, None));
    }
    if arguments.free {
        return Ok((ContactView::Free, None));
    }
    let plain = if arguments.clamped { ContactView::Clamped } else { ContactView::AsDescribed };
    let Some(dependence) = force_dependence(scenario, arguments.clamped) else { return Ok((plain, None)) };
    if let Some(preload_n) = wanted_force_n(scenario) {
        let force = with_unit(preload_n, Units::of(&scenario.machine).force);
        let note = format!(
            "{}; linearised at the final reference, {force} (--preload chooses another)",
            words(dependence)
        );
        return Ok((ContactView::Pressed { preload_n }, Some(note)));
    }
    match dependence {
        Dependence::Vanishing => Err(BadInput::error(
            format!(
                "{}: the contact has no stiffness without force, and no reference of the file is a force \
                 above zero",
                arguments.file.display()
            ),
            "give the force with --preload, as in --preload 30, or analyse without contact with --free",
        )),
        Dependence::Contact => {
            let note = format!(
                "{}; linearised without force, since the file has no force reference (--preload sets one)",
                words(dependence)
            );
            Ok((plain, Some(note)))
        }
        // Without a pressing force the tip just touches.
        Dependence::Position => Ok((plain, None)),
    }
}

/// The part that depends on the force, in words.
fn words(dependence: Dependence) -> &'static str {
    match dependence {
        Dependence::Position => "a force of the machine depends on position",
        Dependence::Contact | Dependence::Vanishing => {
            "the contact's stiffness or damping depends on its force"
        }
    }
}
