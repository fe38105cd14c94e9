//! `[run]`: the default record, and limits on the size of a run.

use std::collections::HashSet;
use std::f64::consts::TAU;

use feeler_catalogue::{Field, Keyed, compact};
use feeler_control::ControllerSpec;
use feeler_engine::{ControllerUse, Integrator, RunSettings};
use feeler_multibody::LARGEST_TURN;
use feeler_plant::assembly::resolve;
use feeler_plant::description::{Axis, Body, Contact, Elements, Machine, Quantity, SignalName, Spring};
use feeler_plant::names::did_you_mean;

use super::{Builder, integrator};
use crate::keys::surface::SURFACE;
use crate::keys::{BODIES, CONTROLLERS, RUN, RUN_TABLE};
use crate::read::Reader;
use crate::source::Origin;
use crate::tree::{Entry, Table, Value, locate, node_at};

/// Largest number of steps of a fixed-step integrator.
const MOST_STEPS: f64 = 1e8;
/// Largest number of samples of all controllers together: some minutes of work.
const MOST_SAMPLES: f64 = 2e8;
/// Largest number of cycles of the fastest vibration: contacts may open and close in each, and every such
/// event is located.
const MOST_CYCLES: f64 = 1e8;
/// Shortest ordinary period. If a run has too many samples or vibrations, a shorter period is reported as the
/// mistake; otherwise the duration is.
const ORDINARY_S: f64 = 1e-5;
/// Largest number of bodies: every mode has matrices of twice as many rows, and their exponentials cost the
/// cube of that.
const MOST_BODIES: usize = 256;
/// Highest rate of a record. A row takes about a microsecond, so ten simulated milliseconds take a second.
const MOST_RATE_HZ: f64 = 1e8;
/// Largest number of rows of a record.
const MOST_ROWS: f64 = 1e7;
/// Largest number of values in a record: 0.8 GB.
const MOST_VALUES: f64 = 1e8;

fn written<'t>(table: &'t Table, field: &Field<RunSettings>) -> Option<&'t Entry> {
    table.get(field.key.name)
}

impl Builder<'_> {
    /// How to run the scenario.
    pub(crate) fn run(&mut self, machine: &Machine, controllers: &Elements<ControllerUse>) -> RunSettings {
        let empty = Table::new();
        let top = self.draft.top();
        let draft = self.draft;
        let (table, at) = (draft.root.get(RUN_TABLE))
            .and_then(|entry| {
                let remedy = format!("write [{RUN_TABLE}]");
                Some((self.problems.table(&entry.node, RUN_TABLE, remedy)?, &entry.node.origin))
            })
            .unwrap_or((&empty, &top));
        let scope = self.scope();
        let before = self.problems.count();
        let fields = Reader { problems: self.problems, scope }.fields(&RUN, &[], table, at, RUN_TABLE);
        let sound = self.problems.count() == before;
        let mut run = RunSettings::default();
        run.take(&fields);
        if run.integrator != Integrator::External && written(table, &RunSettings::INTEGRATOR).is_none() {
            run.integrator = integrator::by_default(machine, run.step_s);
        }
        if let (Integrator::External, Some(entry)) =
            (run.integrator, written(table, &RunSettings::INTEGRATOR))
        {
            let message = format!(
                "with `{} = \"rapier\"` Rapier steps the bodies, and no integrator is chosen",
                RunSettings::key(&RunSettings::ENGINE)
            );
            self.problems.add(
                &entry.node.origin,
                RunSettings::key(&RunSettings::INTEGRATOR),
                message,
                "leave one of them out",
            );
        }
        if run.integrator == Integrator::External && machine.axis == Axis::Rotational {
            self.turns(machine, run.step_s);
        }
        if written(table, &RunSettings::RECORD).is_none() {
            run.record = default_record(machine);
        }
        self.signals(table, machine, controllers);
        if sound {
            self.size(&run, table, at);
            self.work(
                &run,
                machine,
                controllers,
                written(table, &RunSettings::DURATION).map_or(at, |entry| &entry.node.origin),
            );
        }
        run
    }

    /// Whether each recorded signal exists.
    fn signals(&mut self, table: &Table, machine: &Machine, controllers: &Elements<ControllerUse>) {
        let Some(entry) = written(table, &RunSettings::RECORD) else { return };
        let Value::Array(items) = &entry.node.value else { return };
        let key = RunSettings::key(&RunSettings::RECORD);
        if items.is_empty() {
            let message = "no signal is named: the record would hold times alone";
            let record = RunSettings::RECORD.key.name;
            let remedy = format!("name signals, as in \"tool.force\", or leave `{record}` out");
            self.problems.add(&entry.node.origin, key.as_str(), message, remedy);
        }
        let mut seen = HashSet::new();
        for item in items {
            let Some(Ok(signal)) = item.as_text().map(str::parse::<SignalName>) else { continue };
            if !seen.insert(signal.to_string()) {
                self.problems.add(
                    &item.origin,
                    key.as_str(),
                    format!("`{signal}` is recorded twice"),
                    "write it once",
                );
            }
            if matches!(signal.quantity, Quantity::Output | Quantity::Reference) {
                if node_at(&self.draft.root, &[CONTROLLERS.table, &signal.element]).is_none() {
                    let remedy = did_you_mean(&signal.element, controllers.keys().map(String::as_str));
                    self.problems.add(
                        &item.origin,
                        key.as_str(),
                        format!("there is no controller `{}`", signal.element),
                        remedy,
                    );
                }
            } else if self.has_bad_surface(machine, &signal) {
                // The mistake is in the surface, and has been reported.
            } else if let Err(problem) = resolve(machine, &signal) {
                self.problems.add(&item.origin, key.as_str(), problem.message, problem.remedy);
            }
        }
    }

    /// Whether a signal belongs to shapes in the file that could not be read.
    fn has_bad_surface(&self, machine: &Machine, signal: &SignalName) -> bool {
        let written = locate(&self.draft.root, &SURFACE.of::<Contact>(&signal.element)).1;
        signal.quantity.of_touch().is_some() && written && !machine.profiles.contains_key(&signal.element)
    }

    fn size(&mut self, run: &RunSettings, table: &Table, at: &Origin) {
        let place = |field: &Field<RunSettings>| written(table, field).map_or(at, |entry| &entry.node.origin);
        let duration = run.duration_s;
        let steps = duration / run.step_s;
        if run.integrator != Integrator::Exact && steps > MOST_STEPS {
            let message = format!(
                "{} s / {} s = {steps:.3e} steps, and at most {MOST_STEPS:.0e} are taken",
                compact(duration),
                compact(run.step_s)
            );
            self.problems.add(
                place(&RunSettings::STEP),
                RunSettings::key(&RunSettings::STEP),
                message,
                "lengthen the step, shorten the run, or use the exact integrator",
            );
        }
        let rate = run.record_rate_hz.unwrap_or(1.0 / run.step_s);
        let rate_key = RunSettings::RECORD_RATE.key.name;
        let rows = duration * rate;
        let signals = run.record.len();
        let values = rows * signals as f64;
        let is_stated = written(table, &RunSettings::RECORD_RATE).is_some();
        let field = if is_stated { RunSettings::RECORD_RATE } else { RunSettings::DURATION };
        if rows > MOST_ROWS || values > MOST_VALUES {
            let message = format!(
                "{} s * {rate} Hz = {rows:.3e} rows of {signals} signals = {values:.3e} numbers ({:.1} GB), \
                 and at most {MOST_ROWS:.0e} rows and {MOST_VALUES:.0e} numbers are recorded",
                compact(duration),
                values * 8e-9
            );
            self.problems.add(
                place(&field),
                RunSettings::key(&field),
                message,
                format!("lower `{rate_key}`, record fewer signals, or shorten the run"),
            );
        }
        if rate > MOST_RATE_HZ {
            let message = format!(
                "a row every {} s, and at most {MOST_RATE_HZ:.0e} rows a second",
                compact(1.0 / rate)
            );
            let field = if is_stated { RunSettings::RECORD_RATE } else { RunSettings::STEP };
            self.problems.add(
                place(&field),
                RunSettings::key(&field),
                message,
                format!("lower `{rate_key}`; a number without a unit is in hertz"),
            );
        }
        if rows < 1.0 {
            let message = format!(
                "{duration} s * {rate} Hz = {rows:.3e} rows: the record would hold its first instant alone"
            );
            self.problems.add(
                place(&field),
                RunSettings::key(&field),
                message,
                format!("raise `{rate_key}`, or lengthen the run"),
            );
        }
    }

    /// Rejects bodies that start faster than Rapier can follow.
    fn turns(&mut self, machine: &Machine, step_s: f64) {
        for (name, body) in &machine.bodies {
            let turn = body.velocity_m_per_s.abs() * step_s;
            if turn > LARGEST_TURN {
                let key = Body::VELOCITY.of(name);
                let message = format!(
                    "{} rad/s turn this body by {turn:.3} rad in a step of {} s, and Rapier follows a turn \
                     of at most {LARGEST_TURN:.3} rad per step",
                    compact(body.velocity_m_per_s),
                    compact(step_s),
                );
                let remedy = format!(
                    "shorten `{}` to {:.3e} s or less, or leave `{}` out",
                    RunSettings::key(&RunSettings::STEP),
                    step_s * LARGEST_TURN / turn,
                    RunSettings::key(&RunSettings::ENGINE)
                );
                let at = locate(&self.draft.root, &key).0.unwrap_or(self.draft.top());
                self.problems.add(&at, key, message, remedy);
            }
        }
    }

    /// Rejects runs that would take hours, with the arithmetic: samples of the controllers, cycles of the
    /// fastest vibration, bodies.
    fn work(
        &mut self,
        run: &RunSettings,
        machine: &Machine,
        controllers: &Elements<ControllerUse>,
        duration_at: &Origin,
    ) {
        let duration = run.duration_s;
        let samples: f64 = controllers.values().map(|used| duration / used.spec.period_s).sum();
        if samples > MOST_SAMPLES {
            let fastest =
                controllers.iter().min_by(|(_, a), (_, b)| a.spec.period_s.total_cmp(&b.spec.period_s));
            let (name, period) =
                fastest.map_or(("", 1.0), |(name, used)| (name.as_str(), used.spec.period_s));
            let message = format!(
                "{} s / {} s (and all other controllers) = {samples:.3e} samples, and at most \
                 {MOST_SAMPLES:.0e} are taken",
                compact(duration),
                compact(period)
            );
            let (key, remedy) = if period < ORDINARY_S {
                (ControllerSpec::PERIOD.of(name), "lengthen the period, or shorten the run")
            } else {
                (RunSettings::key(&RunSettings::DURATION), "shorten the run, or lengthen the period")
            };
            self.refuse_work(key, message, remedy, duration_at);
        }
        if let Some((key, frequency_hz, why)) = fastest_motion(machine) {
            let cycles = duration * frequency_hz;
            if cycles > MOST_CYCLES {
                let message = format!(
                    "{why} = {} Hz, and {} s of it are {cycles:.3e} cycles; at most {MOST_CYCLES:.0e} are \
                     followed",
                    rounded(frequency_hz),
                    compact(duration)
                );
                let (key, remedy) = if frequency_hz * ORDINARY_S > 1.0 {
                    (key, "make it less or the body heavier, join the bodies rigidly, or shorten the run")
                } else {
                    (RunSettings::key(&RunSettings::DURATION), "shorten the run")
                };
                self.refuse_work(key, message, remedy, duration_at);
            }
        }
        if machine.bodies.len() > MOST_BODIES {
            let message =
                format!("there are {} bodies, and at most {MOST_BODIES} are followed", machine.bodies.len());
            self.refuse_work(BODIES.table.to_owned(), message, "lump bodies that move together", duration_at);
        }
    }

    fn refuse_work(&mut self, key: String, message: String, remedy: &str, otherwise: &Origin) {
        let at = locate(&self.draft.root, &key).0.unwrap_or_else(|| otherwise.clone());
        self.problems.add(&at, key, message, remedy);
    }
}

/// A number with about four significant digits.
fn rounded(value: f64) -> String {
    if value < 1e6 { format!("{value:.1}") } else { format!("{value:.3e}") }
}

/// The largest `sqrt(k / m) / 2 pi` or `c / m / 2 pi` of a linear spring or contact with the lighter body at
/// its ends: its key, the frequency, and its derivation.
fn fastest_motion(machine: &Machine) -> Option<(String, f64, String)> {
    let springs = machine.springs.iter().filter(|(_, spring)| !spring.rigid);
    let springs = springs.map(|(name, spring)| {
        let keys = [Spring::STIFFNESS, Spring::DAMPING].map(|field| field.of(name));
        (keys, &spring.between, spring.stiffness_n_per_m, spring.damping_n_s_per_m)
    });
    let linear = |contact: &Contact| contact.law.exponent().total_cmp(&1.0).is_eq();
    let contacts = machine.contacts.iter().filter(|(_, contact)| linear(contact));
    let contacts = contacts.map(|(name, contact)| {
        let keys = [Contact::STIFFNESS, Contact::DAMPING].map(|field| field.of(name));
        (keys, &contact.between, contact.stiffness, contact.damping_n_s_per_m)
    });
    let of =
        |([of_stiffness, of_damping], between, stiffness, damping): ([String; 2], &[String; 2], f64, f64)| {
            let mass = between
                .iter()
                .filter_map(|name| machine.bodies.get(name))
                .map(|body| body.mass_kg)
                .min_by(f64::total_cmp)?;
            let vibration = (of_stiffness, (stiffness / mass).sqrt() / TAU);
            let decay = (of_damping, damping / mass / TAU);
            let mass = compact(mass);
            Some(if decay.1 > vibration.1 {
                (decay.0, decay.1, format!("{} N s/m / {mass} kg / 2 pi", compact(damping)))
            } else {
                (vibration.0, vibration.1, format!("sqrt({} N/m / {mass} kg) / 2 pi", compact(stiffness)))
            })
        };
    springs.chain(contacts).filter_map(of).max_by(|a, b| a.1.total_cmp(&b.1))
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
