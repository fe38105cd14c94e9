//! From the name of a signal to its source.

use super::Source;
use crate::description::{Actuator, ActuatorKind, Machine, Quantity, SignalName};
use crate::names::{list, nearest};
use crate::problem::Problem;

/// The signal of a machine's plant with this name.
///
/// # Errors
/// A [`Problem`] with an empty key if the element does not exist or does not have that quantity.
pub fn resolve(machine: &Machine, signal: &SignalName) -> Result<Source, Problem> {
    let name = signal.element.as_str();
    let quantity = signal.quantity;
    // Elements of different kinds may share a name; the quantity selects one.
    let candidates = [
        (
            machine.bodies.get_index_of(name).map(|i| i + 1),
            BODY,
            Source::Node as fn(usize, Quantity) -> Source,
        ),
        (machine.contacts.get_index_of(name), CONTACT, Source::Contact),
        (machine.actuators.get_index_of(name), ACTUATOR, Source::Drive),
        (machine.springs.get_index_of(name), SPRING, Source::Link),
        (machine.sensors.get_index_of(name), SENSOR, |i, _| Source::Sensor(i)),
    ];
    let named = candidates.iter().filter_map(|(index, has, source)| index.map(|i| (i, *has, source)));
    if let Some(source) = machine.actuators.get_full(name).and_then(|(i, _, a)| of_kind(i, a, quantity)) {
        return Ok(source);
    }
    if let Some((i, _, source)) = named.clone().find(|(_, has, _)| has.contains(&quantity)) {
        if quantity.of_touch().is_some()
            && !machine.profiles.get(name).is_some_and(|profile| profile.has_touches())
        {
            let message =
                format!("the contact `{name}` has no shapes, so that it has no `{}`", quantity.name());
            return Err(Problem::new(
                "",
                message,
                format!("give it a `surface`, or leave `{name}.{}` out", quantity.name()),
            ));
        }
        return Ok(source(i, quantity));
    }
    if let Some((_, has, _)) = named.clone().next() {
        let has: Vec<&str> = has.iter().map(|q| q.name()).collect();
        return Err(Problem::new(
            "",
            format!("`{name}` has no `{}`", quantity.name()),
            format!("it has {}", has.join(", ")),
        ));
    }
    // Only elements with this quantity qualify.
    let kinds: [(Vec<&String>, &[Quantity]); 5] = [
        (machine.bodies.keys().collect(), BODY),
        (machine.contacts.keys().collect(), CONTACT),
        (machine.actuators.keys().collect(), ACTUATOR),
        (machine.sensors.keys().collect(), SENSOR),
        (machine.springs.keys().collect(), SPRING),
    ];
    let names = kinds
        .into_iter()
        .filter(|(_, has)| has.contains(&quantity))
        .flat_map(|(names, _)| names)
        .map(String::as_str);
    let names: Vec<&str> = names.collect();
    let remedy = match nearest(name, names.iter().copied()) {
        Some(near) => format!("did you mean `{near}.{}`?", quantity.name()),
        None if names.is_empty() => format!("nothing in this machine has a `{}`", quantity.name()),
        None => format!("a `{}` is of {}", quantity.name(), list(names)),
    };
    Err(Problem::new("", format!("there is no element `{name}`"), remedy))
}

/// Quantities of some kinds of actuators only: their command under its own name, and the current of a motor.
fn of_kind(i: usize, actuator: &Actuator, quantity: Quantity) -> Option<Source> {
    let is_motor = matches!(actuator.kind, ActuatorKind::DcMotor(_));
    if quantity == Quantity::Current && is_motor {
        return Some(Source::Drive(i, Quantity::Current));
    }
    let is_input = quantity != Quantity::Command && quantity == actuator.kind.input();
    is_input.then_some(Source::Drive(i, Quantity::Command))
}

/// Quantities of each kind of element.
const BODY: &[Quantity] = &[Quantity::Position, Quantity::Velocity, Quantity::Acceleration];
const CONTACT: &[Quantity] = &[
    Quantity::Force,
    Quantity::SpringForce,
    Quantity::Compression,
    Quantity::Gap,
    Quantity::GapRate,
    Quantity::PointX,
    Quantity::PointY,
    Quantity::PointZ,
    Quantity::NormalX,
    Quantity::NormalY,
    Quantity::NormalZ,
    Quantity::Contact,
];
const ACTUATOR: &[Quantity] = &[Quantity::Command, Quantity::Force, Quantity::Position, Quantity::Velocity];
const SPRING: &[Quantity] = &[Quantity::Force, Quantity::SpringForce];
const SENSOR: &[Quantity] = &[Quantity::Reading];
