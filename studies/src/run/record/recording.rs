//! Signals that are recorded to measure and show a run, beyond those in the file.

use feeler_engine::{Integrator, RunSettings, Scenario, Trace};
use feeler_plant::description::{ActuatorKind, Machine, Quantity, SignalName};
use feeler_plant::effects::Trait;

use crate::run::measure::controlled::Controlled;
use crate::run::measure::standing::nothing_can_touch;
use crate::run::measure::stiction;

/// Smallest rate of the measures: a force peak of 150 Hz is then met within 0.3 %. A parabola finds the rest
/// if the engine does not find peaks itself.
const MEASURE_RATE_HZ: f64 = 1e4;
/// Rate if only measures are needed; the engine finds the peaks between rows.
const LEAN_RATE_HZ: f64 = 2e3;
/// Largest number of values recorded beyond the file's own rate: 0.4 GB.
const MOST_VALUES: f64 = 5e7;
/// With more bodies than this, only driven and touching bodies are shown.
const MOST_BODIES: usize = 8;
/// A ratio of spacings this close to a whole number is one.
const WHOLE: f64 = 1e-9;

/// Signals and rate of a record that can be measured.
#[derive(Clone, Debug)]
pub(in crate::run) struct Recording {
    signals: Vec<SignalName>,
    /// Number of signals requested by the file, which come first.
    wanted: usize,
    /// Rows for each row of the file's rate.
    multiple: usize,
    pub(in crate::run) rate_hz: f64,
}

impl Recording {
    /// All important signals of a run, at [`MEASURE_RATE_HZ`] or more.
    pub(in crate::run) fn new(scenario: &Scenario) -> Self {
        let run = &scenario.run;
        let mut signals = run.record.clone();
        for signal in telling(scenario) {
            if !signals.contains(&signal) {
                signals.push(signal);
            }
        }
        let rate_hz = run.record_rate_hz.unwrap_or(1.0 / run.step_s);
        let multiple = multiple(run, rate_hz, MOST_VALUES / signals.len() as f64);
        Self { signals, wanted: run.record.len(), multiple, rate_hz: rate_hz * multiple as f64 }
    }

    /// Only the signals for the measures: a row at every sample of the fastest controller, or a whole number
    /// of rows between two of them.
    pub(in crate::run) fn lean(scenario: &Scenario) -> Self {
        let signals = measured(scenario);
        let run = &scenario.run;
        let fastest_hz =
            scenario.controllers.values().map(|used| 1.0 / used.spec.period_s).fold(0.0, f64::max);
        let wanted_hz =
            if fastest_hz > 0.0 { fastest_hz * (LEAN_RATE_HZ / fastest_hz).ceil() } else { LEAN_RATE_HZ };
        let rate_hz = if run.integrator == Integrator::Exact {
            wanted_hz
        } else {
            // On the grid of the fixed step.
            1.0 / (run.step_s * (1.0 / (wanted_hz * run.step_s) + WHOLE).floor().max(1.0))
        };
        let affordable_hz = MOST_VALUES / (run.duration_s * signals.len().max(1) as f64);
        Self { signals, wanted: 0, multiple: 1, rate_hz: rate_hz.min(affordable_hz) }
    }

    /// The signals of the file and all important signals, at the instants of [`Self::lean`]. Readings are
    /// omitted: a delayed one would add instants.
    pub(in crate::run) fn as_swept(scenario: &Scenario) -> Self {
        let mut signals: Vec<SignalName> = scenario
            .run
            .record
            .iter()
            .filter(|signal| signal.quantity != Quantity::Reading)
            .cloned()
            .collect();
        let wanted = signals.len();
        for signal in telling(scenario) {
            if !signals.contains(&signal) {
                signals.push(signal);
            }
        }
        Self { signals, wanted, ..Self::lean(scenario) }
    }

    pub(in crate::run) fn settings(&self, run: &RunSettings) -> RunSettings {
        RunSettings {
            record: self.signals.clone(),
            record_rate_hz: Some(self.rate_hz),
            peaks: true,
            ..run.clone()
        }
    }

    /// The part of a record that the file requests.
    pub(in crate::run) fn wanted(&self, record: &Trace) -> Trace {
        let thin = |column: &Vec<f64>| column.iter().step_by(self.multiple).copied().collect::<Vec<_>>();
        Trace {
            names: record.names[..self.wanted].to_vec(),
            t_s: thin(&record.t_s),
            columns: record.columns[..self.wanted].iter().map(thin).collect(),
            events: record.events.clone(),
        }
    }
}

/// Rows for each requested row. A fixed step ends at every row, so the finer rows must fall on its own grid.
fn multiple(run: &RunSettings, rate_hz: f64, most_rows: f64) -> usize {
    let most = most_rows / (run.duration_s * rate_hz).max(1.0);
    let needed = (MEASURE_RATE_HZ / rate_hz).ceil().min(most.floor()).max(1.0);
    if run.integrator == Integrator::Exact {
        return needed as usize;
    }
    let steps = 1.0 / (rate_hz * run.step_s);
    if (steps - steps.round()).abs() > WHOLE * steps || steps < 1.0 {
        return 1;
    }
    let steps = steps.round() as usize;
    (1..=needed as usize).rev().find(|k| steps.is_multiple_of(*k)).unwrap_or(1)
}

/// The signals for the measures of a run.
fn measured(scenario: &Scenario) -> Vec<SignalName> {
    let mut signals = Vec::new();
    for name in scenario.machine.contacts.keys() {
        signals.extend([Quantity::Force, Quantity::Contact].map(|quantity| SignalName::new(name, quantity)));
    }
    for (name, actuator) in &scenario.machine.actuators {
        let is_force = matches!(actuator.kind, ActuatorKind::Force { .. });
        if is_force {
            signals.push(SignalName::new(name, Quantity::Command));
        }
        let drifts = actuator.effects.iter().any(|effect| effect.definition.has(Trait::Drift));
        if !is_force || drifts {
            signals.push(SignalName::new(name, Quantity::Force));
        }
    }
    signals.extend(controlled(scenario));
    signals.extend(stiction::signals(&scenario.machine));
    for (name, used) in &scenario.controllers {
        signals.push(SignalName::new(name, Quantity::Reference));
        if used.spec.output_limit.is_some() {
            signals.push(SignalName::new(name, Quantity::Output));
        }
    }
    signals
}

/// The motion that decides the outcome of a run in which nothing can touch; `None` if a force does.
pub fn controlled(scenario: &Scenario) -> Option<SignalName> {
    nothing_can_touch(scenario).then(|| Controlled::find(scenario)).flatten().map(|found| found.signal)
}

/// The most important signals of a run: contacts, drives, controllers, and bodies.
fn telling(scenario: &Scenario) -> Vec<SignalName> {
    let machine = &scenario.machine;
    let mut signals = Vec::new();
    let mut add = |name: &str, quantities: &[Quantity]| {
        signals.extend(quantities.iter().map(|&quantity| SignalName::new(name, quantity)));
    };
    for name in machine.contacts.keys() {
        add(name, &[Quantity::Force, Quantity::Compression, Quantity::Contact]);
    }
    for name in machine.actuators.keys() {
        add(name, &[Quantity::Command, Quantity::Force]);
    }
    for name in scenario.controllers.keys() {
        add(name, &[Quantity::Output, Quantity::Reference]);
    }
    for name in telling_bodies(machine) {
        add(name, &[Quantity::Position, Quantity::Velocity]);
    }
    for signal in controlled(scenario).into_iter().chain(stiction::signals(machine)) {
        if !signals.contains(&signal) {
            signals.push(signal);
        }
    }
    signals
}

fn telling_bodies(machine: &Machine) -> impl Iterator<Item = &str> {
    let touches =
        |name: &str| machine.contacts.values().any(|contact| contact.between.iter().any(|body| body == name));
    let driven = |name: &str| {
        machine.actuators.values().any(|actuator| actuator.on == name || actuator.reacts_on == name)
    };
    let few = machine.bodies.len() <= MOST_BODIES;
    machine.bodies.keys().map(String::as_str).filter(move |name| few || touches(name) || driven(name))
}

/// After a motion has diverged its signals are NaN: such rows are removed.
pub(in crate::run) fn drop_undefined_rows(record: &mut Trace) {
    let defined = |row: usize| record.columns.iter().all(|column| column[row].is_finite());
    let rows = (0..record.t_s.len()).rev().find(|&row| defined(row)).map_or(0, |row| row + 1);
    record.t_s.truncate(rows);
    for column in &mut record.columns {
        column.truncate(rows);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(integrator: Integrator, step_s: f64, rate_hz: f64) -> RunSettings {
        RunSettings { integrator, step_s, record_rate_hz: Some(rate_hz), ..RunSettings::default() }
    }

    #[test]
    fn truth_the_measuring_rate_is_a_multiple_of_the_record_rate() {
        let of = |integrator, step_s, rate_hz| {
            multiple(&settings(integrator, step_s, rate_hz), rate_hz, MOST_VALUES / 10.0)
        };
        assert_eq!(of(Integrator::Exact, 1e-4, 2e3), 5);
        assert_eq!(of(Integrator::Exact, 1e-4, 2e4), 1);
        assert_eq!(of(Integrator::Exact, 1e-4, 3e3), 4);
        // Rows of a fixed step fall on its steps: 1 / 2 kHz = 2 steps of 0.25 ms.
        assert_eq!(of(Integrator::Rk4, 0.25e-3, 2e3), 2);
        assert_eq!(of(Integrator::Rk4, 0.3e-3, 2e3), 1);
        assert_eq!(of(Integrator::SemiImplicitEuler, 1e-6, 2e3), 5);
    }

    #[test]
    fn truth_long_records_are_not_refined_beyond_bounds() {
        let long = RunSettings { duration_s: 1e5, ..settings(Integrator::Exact, 1e-4, 1e3) };
        assert_eq!(multiple(&long, 1e3, MOST_VALUES / 10.0), 1);
    }
}
