//! The force at which a scenario is linearised: one rule for linear theory, maps and explanations.

use feeler_analysis::{ContactView, View};
use feeler_control::{Law, Reference, ReferenceSpec};
use feeler_engine::Scenario;
use feeler_plant::assembly::assemble;
use feeler_plant::description::Engagement;

use crate::run::{ForceLoop, nothing_can_touch};

/// Default force of the linearisation if stiffness depends on it and no reference gives it, N.
const PRELOAD_N: f64 = 10.0;

/// The part of a machine that depends on the contact's force, or on the position at which it is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dependence {
    /// A contact that has no stiffness without force.
    Vanishing,
    /// A contact's stiffness or damping.
    Contact,
    /// A force over position: of a spring that hardens, gravity, a ripple or a table.
    Position,
}

/// The part of a machine that depends on the contact's force. Effects are included, since they change the
/// laws. `clamped` includes contacts that are absent in the file.
pub fn force_dependence(scenario: &Scenario, clamped: bool) -> Option<Dependence> {
    let assembly = assemble(&scenario.machine).ok()?;
    let touching: Vec<_> = assembly
        .contacts
        .iter()
        .filter(|contact| clamped || contact.engagement != Engagement::Free)
        .collect();
    if touching.iter().any(|contact| contact.law.exponent > 1.0) {
        return Some(Dependence::Vanishing);
    }
    if touching.iter().any(|contact| !contact.law.is_linear()) {
        return Some(Dependence::Contact);
    }
    (assembly.depends_on_position() && !touching.is_empty()).then_some(Dependence::Position)
}

/// The final force reference of a scenario if positive, N: of its force loop, else of the first controller
/// with a force reference. For a reference that never ends it is the mean.
pub fn wanted_force_n(scenario: &Scenario) -> Option<f64> {
    let of_force = |law: &Law| matches!(law, Law::ExplicitForce(_) | Law::Admittance(_));
    let of_loop = ForceLoop::find(scenario).map(|found| found.controller);
    let index =
        of_loop.or_else(|| scenario.controllers.values().position(|used| of_force(&used.spec.law)))?;
    let force_n = match &scenario.controllers[index].spec.reference {
        ReferenceSpec::Multisine { offset, .. }
        | ReferenceSpec::WhiteNoise { offset, .. }
        | ReferenceSpec::Prbs { offset, .. } => *offset,
        lasting => Reference::new(lasting, 0, "").ok()?.value(f64::MAX),
    };
    Some(force_n).filter(|force_n| *force_n > 0.0)
}

/// The linear view of a scenario's contact: absent if it never touches, attached, or pressed with
/// [`wanted_force_n`] if something depends on the force.
pub fn contact_view(scenario: &Scenario) -> View {
    if nothing_can_touch(scenario) {
        return View::FREE;
    }
    let preload_n = match (force_dependence(scenario, true), wanted_force_n(scenario)) {
        // Without a pressing force the tip just touches.
        (None, _) | (Some(Dependence::Position), None) => return View::CLAMPED,
        (Some(_), wanted_n) => wanted_n.unwrap_or(PRELOAD_N),
    };
    View { contact: ContactView::Pressed { preload_n }, ..View::CLAMPED }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_files::Document;

    fn scenario(contact: &str, reference: &str, duration: &str) -> Scenario {
        let text = format!(
            "[bodies.tip]\nmass = 2.0\n[contacts.tool]\nbetween = [\"tip\", \"ground\"]\ndamping = \
             0.0\n{contact}\n[actuators.drive]\non = \"tip\"\n\
             kind = \"force\"\n[sensors.force]\nreads = \"tool.force\"\n[controllers.force]\nlaw \
             = \"explicit-force\"\nreads = \"force\"\n\
             drives = \"drive\"\nperiod = \"1 ms\"\nreference = {reference}\n[run]\nduration = {duration}\n"
        );
        Document::parse(&text, "it.toml").unwrap_or_else(|error| panic!("{error}")).scenario
    }

    const HERTZ: &str = "law = \"hertz\"\nstiffness = 1e8";

    /// The step to 30 N comes after the end of the run, whose duration is independent of it.
    #[test]
    fn regress_the_force_is_that_of_the_reference_s_end_whatever_the_run_s_length() {
        for duration in ["1.0", "3.0"] {
            let scenario = scenario(HERTZ, "[[0.0, 10.0], [2.0, 30.0]]", duration);
            assert_eq!(contact_view(&scenario).contact, ContactView::Pressed { preload_n: 30.0 });
        }
        let noise = "{ kind = \"white-noise\", rms = 1.0, band = [1.0, 50.0], offset = 25.0 }";
        assert_eq!(
            contact_view(&scenario(HERTZ, noise, "1.0")).contact,
            ContactView::Pressed { preload_n: 25.0 }
        );
        assert_eq!(
            contact_view(&scenario(HERTZ, "0.0", "1.0")).contact,
            ContactView::Pressed { preload_n: PRELOAD_N }
        );
    }

    #[test]
    fn truth_a_linear_contact_is_clamped_and_an_absent_one_free() {
        assert_eq!(contact_view(&scenario("stiffness = 1e5", "20.0", "1.0")), View::CLAMPED);
        assert_eq!(
            contact_view(&scenario("stiffness = 1e5\nengagement = \"free\"", "20.0", "1.0")),
            View::FREE
        );
    }
}
