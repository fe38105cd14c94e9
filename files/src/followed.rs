//! Columns of a dataset that are inputs under other names than `<actuator>.command`. They are the reference
//! of a controller in the machine file (`controllers.force.reference`), an imposed position
//! (`bodies.rig.position`), and the current of a motor that it commands.

use feeler_catalogue::{Dimension, Tabled};
use feeler_engine::{ControllerUse, Scenario};
use feeler_plant::assembly::{Source, resolve};
use feeler_plant::description::{Actuator, ActuatorKind, Axis, Body, Machine, Quantity, SignalName};
use feeler_plant::names::did_you_mean;
use feeler_plant::problem::Problem;

use indexmap::IndexMap;

use super::document::Document;
use super::keys::dataset::ColumnSpec;
use super::read::Scope;

/// The controller whose reference the signal is; `None` for other signals.
pub fn followed_by(signal: &SignalName) -> Option<&str> {
    let name = signal.element.as_str();
    (signal.quantity == Quantity::Reference).then(|| ControllerUse::within(name).unwrap_or(name))
}

/// The signal without `bodies.` before the name of a body.
pub(crate) fn plain(signal: SignalName, machine: &Machine) -> SignalName {
    match Body::within(&signal.element) {
        Some(body) if machine.bodies.contains_key(body) => SignalName::new(body, signal.quantity),
        _ => signal,
    }
}

/// Marks columns that hold the command of a drive under another name as commands. These are the position of
/// an imposed body, and the current of a current-driven motor. If another column holds the command, they
/// remain measurements.
pub(crate) fn name_commands(columns: &mut IndexMap<String, ColumnSpec>, scenario: &Scenario) {
    let machine = &scenario.machine;
    for (i, (drive, actuator)) in machine.actuators.iter().enumerate() {
        let input = match actuator.kind {
            ActuatorKind::Imposed => SignalName::new(&actuator.on, Quantity::Position),
            kind if kind.input() == Quantity::Current => SignalName::new(drive, Quantity::Current),
            _ => continue,
        };
        let leads = |signal: &SignalName| match followed_by(signal) {
            Some(name) => scenario.controllers.get(name).is_some_and(|used| used.drives == *drive),
            None => resolve(machine, signal).is_ok_and(|of| of == Source::Drive(i, Quantity::Command)),
        };
        if columns.values().any(|column| leads(&column.signal)) {
            continue;
        }
        if let Some(column) = columns.values_mut().find(|column| column.signal == input) {
            column.signal = SignalName::new(drive, Quantity::Command);
        }
    }
}

/// Why the loop of a controller cannot run while a record is predicted.
pub(crate) fn problem(machine: &Document, name: &str) -> Option<Problem> {
    let all = &machine.scenario.controllers;
    let Some(own) = all.get(name) else {
        let message = format!("the machine's file has no controller `{name}`");
        let remedy = if all.is_empty() {
            format!("add [controllers.{name}], or name the command of a drive")
        } else {
            did_you_mean(name, all.keys().map(String::as_str))
        };
        return Some(Problem::new("", message, remedy));
    };
    let drive = &own.drives;
    if let Some((other, _)) = all.iter().find(|(other, used)| *other != name && used.drives == *drive) {
        let message = format!("`{other}` drives `{drive}` too, but its reference was not recorded");
        return Some(Problem::new("", message, format!("leave [controllers.{other}] out")));
    }
    let kind = machine.scenario.machine.actuators.get(drive).map(|actuator| actuator.kind);
    let (message, remedy) = match kind {
        Some(ActuatorKind::PositionServo(servo)) if servo.period_s.is_some() => (
            format!("`{drive}` has its own sampled loop, and nested loops are not predicted"),
            format!(
                "leave out the `{}` of `{drive}`, or name its target instead",
                Actuator::SERVO_PERIOD.key.name
            ),
        ),
        Some(ActuatorKind::Imposed) => (
            format!("the motion of `{drive}` is imposed, and no loop moves it"),
            format!("name `{drive}.command` instead"),
        ),
        _ => return None,
    };
    Some(Problem::new("", message, remedy))
}

/// Units of the reference of a controller.
pub(crate) fn scope(machine: &Document, name: &str) -> Scope {
    let scenario = &machine.scenario;
    let rotational = Scope::new(scenario.machine.axis == Axis::Rotational);
    // The absence of the controller is reported elsewhere, so its unit is not a second mistake.
    let Some(own) = scenario.controllers.get(name) else {
        return Scope { signal: Dimension::UNKNOWN, ..rotational };
    };
    let output = scenario.machine.actuators.get(&own.drives).map_or(Dimension::NONE, |a| a.kind.command());
    let scope = Scope { output, ..rotational };
    Scope { signal: scope.dim(own.spec.law.follows()), ..scope }
}
