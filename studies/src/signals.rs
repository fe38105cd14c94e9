//! Signals of a machine by the names that users write.

use feeler_plant::assembly::resolve;
use feeler_plant::description::{Machine, Quantity, SignalName};
use feeler_plant::names::{list, nearest};

use crate::refusal::Refusal;

/// The signal of a machine with this name.
///
/// # Errors
/// A refusal if the machine has no such signal, with the nearest one and the complete list.
pub fn named(machine: &Machine, text: &str) -> Result<SignalName, Refusal> {
    match text.parse::<SignalName>() {
        Ok(name) if resolve(machine, &name).is_ok() => Ok(name),
        _ => Err(unknown(text, "signal", &of_machine(machine))),
    }
}

/// The actuator whose command is the named input.
///
/// # Errors
/// A refusal if no actuator has this command, with the existing ones.
pub fn command(machine: &Machine, text: &str) -> Result<SignalName, Refusal> {
    one_of(machine, text, "an actuator's command", &commands(machine))
}

/// The actuator's command or the force on a body that is the named input.
///
/// # Errors
/// A refusal if there is neither, with the existing ones.
pub fn input(machine: &Machine, text: &str) -> Result<SignalName, Refusal> {
    let forces = machine.bodies.keys().map(|body| SignalName::new(body, Quantity::Force).to_string());
    let inputs: Vec<String> = commands(machine).into_iter().chain(forces).collect();
    one_of(machine, text, "an actuator's command or the force on a body", &inputs)
}

fn commands(machine: &Machine) -> Vec<String> {
    machine
        .actuators
        .keys()
        .map(|actuator| SignalName::new(actuator, Quantity::Command).to_string())
        .collect()
}

fn one_of(machine: &Machine, text: &str, what: &str, inputs: &[String]) -> Result<SignalName, Refusal> {
    match text.parse::<SignalName>() {
        Ok(name) if inputs.contains(&name.to_string()) => Ok(name),
        Ok(name) if resolve(machine, &name).is_ok() => Err(Refusal::new(
            format!("`{text}` is not an input: an input is {what}"),
            format!("name one of {}", list(inputs.iter().map(String::as_str))),
        )),
        _ => Err(unknown(text, "input", inputs)),
    }
}

fn unknown(text: &str, what: &str, known: &[String]) -> Refusal {
    let names = || known.iter().map(String::as_str);
    let near = nearest(text, names()).map_or_else(String::new, |near| format!("did you mean `{near}`? "));
    // The whole list, since each name shows its element.
    let all = names().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let there =
        if known.is_empty() { "add one to the machine first".to_owned() } else { format!("there is {all}") };
    Refusal::new(format!("the machine has no {what} `{text}`"), format!("{near}{there}"))
}

/// Every signal of a machine's bodies, springs, contacts, actuators and sensors.
fn of_machine(machine: &Machine) -> Vec<String> {
    let parts = machine.bodies.keys().chain(machine.springs.keys()).chain(machine.contacts.keys());
    let elements = parts.chain(machine.actuators.keys()).chain(machine.sensors.keys());
    let of_element = |element: &String| {
        let all = Quantity::ALL.iter().map(|(quantity, _)| SignalName::new(element, *quantity));
        all.filter(|name| resolve(machine, name).is_ok()).map(|name| name.to_string()).collect::<Vec<_>>()
    };
    elements.flat_map(of_element).collect()
}
