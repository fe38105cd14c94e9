//! `[run]`: what to record where nothing is said, and requests beyond reason.

use feeler_engine::{ControllerUse, Integrator, RunSettings};
use feeler_plant::assembly::resolve;
use feeler_plant::description::{Elements, Machine, Quantity, SignalName};

use super::Builder;
use crate::format::keys::{RAPIER, RUN};
use crate::format::read::{Field, Fields, Reader};
use crate::format::source::Origin;
use crate::format::suggest::did_you_mean;
use crate::format::tree::{Table, Value};

/// Most steps of a fixed-step integrator.
const MOST_STEPS: f64 = 1e8;
/// Most rows of a record.
const MOST_ROWS: f64 = 1e8;
/// Most numbers of a record: 1.6 GB.
const MOST_VALUES: f64 = 2e8;

impl Builder<'_> {
    /// How to run the scenario.
    pub(crate) fn run(&mut self, machine: &Machine, controllers: &Elements<ControllerUse>) -> RunSettings {
        let empty = Table::new();
        let top = Origin { source: self.draft.main, span: 0..0 };
        let (table, at) = match self.draft.root.get("run") {
            None => (&empty, &top),
            Some(entry) => match &entry.node.value {
                Value::Table(table) => (table, &entry.node.origin),
                other => {
                    let message = format!("this must be a table, not {}", other.kind());
                    self.problems.add(&entry.node.origin, "run", message, "write [run]");
                    (&empty, &top)
                }
            },
        };
        let scope = self.scope();
        let before = self.problems.count();
        let fields = Reader { problems: self.problems, scope }.fields(&RUN, &[], table, at, "run");
        let sound = self.problems.count() == before;
        let named = Integrator::ALL.iter().find(|(_, name)| fields.text("integrator") == Some(name)).map(|(i, _)| *i);
        let integrator = if fields.text("engine") == Some(RAPIER) { Integrator::External } else { named.unwrap_or_default() };
        let record = match fields.get("record") {
            Some(Field::Signals(signals)) => signals.clone(),
            _ => default_record(machine),
        };
        self.signals(table, machine, controllers);
        let run = RunSettings {
            duration_s: fields.number("duration"),
            step_s: fields.number("step"),
            integrator,
            seed: fields.count("seed").unwrap_or(1),
            record,
            record_rate_hz: fields.optional("record_rate"),
            energy: fields.flag("energy"),
        };
        if sound {
            self.size(&run, &fields, table, at);
        }
        run
    }

    /// Whether each recorded signal exists.
    fn signals(&mut self, table: &Table, machine: &Machine, controllers: &Elements<ControllerUse>) {
        let Some(Value::Array(items)) = table.get("record").map(|entry| &entry.node.value) else { return };
        for item in items {
            let Some(Ok(signal)) = item.as_text().map(str::parse::<SignalName>) else { continue };
            if matches!(signal.quantity, Quantity::Output | Quantity::Reference) {
                if !controllers.contains_key(&signal.element) {
                    let remedy = did_you_mean(&signal.element, controllers.keys().map(String::as_str));
                    self.problems.add(&item.origin, "run.record", format!("there is no controller `{}`", signal.element), remedy);
                }
            } else if let Err(problem) = resolve(machine, &signal) {
                self.problems.add(&item.origin, "run.record", problem.message, problem.remedy.unwrap_or_default());
            }
        }
    }

    fn size(&mut self, run: &RunSettings, fields: &Fields, table: &Table, at: &Origin) {
        let place = |key: &str| table.get(key).map_or(at, |entry| &entry.node.origin);
        let duration = run.duration_s;
        let steps = duration / run.step_s;
        if run.integrator != Integrator::Exact && steps > MOST_STEPS {
            let message = format!("{duration} s / {} s = {steps:.3e} steps, and at most {MOST_STEPS:.0e} are taken", run.step_s);
            self.problems.add(place("step"), "run.step", message, "lengthen the step, shorten the run, or use the exact integrator");
        }
        let rate = fields.optional("record_rate").unwrap_or(1.0 / run.step_s);
        let rows = duration * rate;
        let signals = run.record.len();
        let values = rows * signals as f64;
        let key = if table.contains_key("record_rate") { "record_rate" } else { "duration" };
        if rows > MOST_ROWS || values > MOST_VALUES {
            let message = format!(
                "{duration} s * {rate} Hz = {rows:.3e} rows of {signals} signals = {values:.3e} numbers ({:.1} GB), and at most {MOST_ROWS:.0e} rows and {MOST_VALUES:.0e} numbers are recorded",
                values * 8e-9
            );
            self.problems.add(place(key), format!("run.{key}"), message, "lower `record_rate`, record fewer signals, or shorten the run");
        }
    }
}

/// Contact forces, positions and velocities of driven bodies, commands and readings.
pub(crate) fn default_record(machine: &Machine) -> Vec<SignalName> {
    let mut record = Vec::new();
    let mut add = |element: &str, quantities: &[Quantity]| {
        for quantity in quantities {
            let signal = SignalName::new(element, *quantity);
            if !record.contains(&signal) {
                record.push(signal);
            }
        }
    };
    for name in machine.contacts.keys() {
        add(name, &[Quantity::Force, Quantity::SpringForce]);
    }
    for actuator in machine.actuators.values().filter(|actuator| machine.bodies.contains_key(&actuator.on)) {
        add(&actuator.on, &[Quantity::Position, Quantity::Velocity]);
    }
    for name in machine.actuators.keys() {
        add(name, &[Quantity::Command]);
    }
    for name in machine.sensors.keys() {
        add(name, &[Quantity::Reading]);
    }
    record
}
