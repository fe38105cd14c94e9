//! A force on a body from outside as an input, as in `tip.force`: that of a disturbance, a person or a
//! passing part.

use std::borrow::Cow;

use feeler_engine::Scenario;
use feeler_plant::description::{Actuator, GROUND, Quantity, SignalName};

/// The scenario in which an input is an actuator's command, and that command: itself where it is one already,
/// else with an ideal force from the ground on the body that the input names.
pub(crate) fn commanded<'a>(scenario: &'a Scenario, input: &SignalName) -> (Cow<'a, Scenario>, SignalName) {
    if input.quantity != Quantity::Force || !scenario.machine.bodies.contains_key(&input.element) {
        return (Cow::Borrowed(scenario), input.clone());
    }
    let mut driven = scenario.clone();
    let name = input.to_string();
    driven.machine.actuators.insert(name.clone(), Actuator::ideal(&input.element, GROUND));
    (Cow::Owned(driven), SignalName::new(&name, Quantity::Command))
}
