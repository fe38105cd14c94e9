//! An external force on a body as an input, as in `tip.force`: a disturbance, a person or a passing part.

use std::borrow::Cow;

use feeler_engine::Scenario;
use feeler_plant::description::{Actuator, GROUND, Quantity, SignalName};

/// The scenario in which an input is an actuator's command, and that command. If the input is a force on a
/// body, an ideal actuator between ground and that body is added.
pub(crate) fn commanded<'a>(scenario: &'a Scenario, input: &SignalName) -> (Cow<'a, Scenario>, SignalName) {
    if input.quantity != Quantity::Force || !scenario.machine.bodies.contains_key(&input.element) {
        return (Cow::Borrowed(scenario), input.clone());
    }
    let mut driven = scenario.clone();
    let name = input.to_string();
    driven.machine.actuators.insert(name.clone(), Actuator::ideal(&input.element, GROUND));
    (Cow::Owned(driven), SignalName::new(&name, Quantity::Command))
}
