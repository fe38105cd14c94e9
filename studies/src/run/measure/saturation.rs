//! Times at which a drive or controller was at its limit.

use feeler_engine::{EventKind, Scenario, Trace};
use feeler_plant::assembly::Assembly;
use feeler_plant::description::{Quantity, SignalName};

use crate::run::record::event::EventRecord;

/// A value this close to its limit is at it: limits act on held numbers, so only rounding separates the two.
const AT_LIMIT: f64 = 1.0 - 1e-9;

/// Instants at which limits were reached.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::run) struct Limits {
    /// For each row of the record, whether some drive or controller was at its limit. Commands and outputs
    /// are held between controller samples, so the share of rows is the share of samples.
    pub(in crate::run) saturated: Vec<bool>,
    /// Times at which a force drive reached its limit and left it. Its clamp acts on held commands, so
    /// nothing changes within a step; the instants are those of the first row that shows it.
    pub(in crate::run) events: Vec<EventRecord>,
}

impl Limits {
    pub(in crate::run) fn of(scenario: &Scenario, assembly: &Assembly, record: &Trace) -> Self {
        let mut limits = Self { saturated: vec![false; record.t_s.len()], events: Vec::new() };
        for drive in assembly.drives.iter().filter(|drive| drive.limit.is_finite()) {
            // A force drive clamps its command; others clamp their effort, which the engine locates.
            if !drive.commands_force() {
                limits.mark(record, &drive.name, Quantity::Force, drive.limit);
                continue;
            }
            let at_limit =
                limits.mark(record, &drive.name, Quantity::Command, drive.limit / drive.gain.abs());
            let changes = at_limit.windows(2).enumerate().filter(|(_, pair)| pair[0] != pair[1]);
            limits.events.extend(changes.map(|(row, pair)| EventRecord {
                t_s: record.t_s[row + 1],
                what: if pair[1] { EventKind::Limit } else { EventKind::Release }.name(),
                on: drive.name.clone(),
            }));
        }
        for (name, used) in &scenario.controllers {
            if let Some(limit) = used.spec.output_limit {
                limits.mark(record, name, Quantity::Output, limit);
            }
        }
        limits
    }

    /// Marks the rows in which a signal is at its limit, and returns them.
    fn mark(&mut self, record: &Trace, element: &str, quantity: Quantity, limit: f64) -> Vec<bool> {
        let column = record.column(&SignalName::new(element, quantity).to_string()).unwrap_or_default();
        let at_limit: Vec<bool> = column.iter().map(|value| value.abs() >= limit * AT_LIMIT).collect();
        for (flag, at_limit) in self.saturated.iter_mut().zip(&at_limit) {
            *flag |= at_limit;
        }
        at_limit
    }
}

/// Share of rows that are marked.
pub(in crate::run) fn share(saturated: &[bool]) -> f64 {
    saturated.iter().filter(|&&flag| flag).count() as f64 / saturated.len().max(1) as f64
}
