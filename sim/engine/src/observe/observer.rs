//! Observers of a run.

use feeler_lanes::Lane;

use crate::observe::event::Event;

/// Receives the record of a run during the run.
///
/// At a sample instant, a controller's outputs and the drives' commands are those issued at that instant. All
/// other values are those just before they act. Values of a variant that has ended early are NaN.
pub trait Observer<L: Lane> {
    /// The recorded signals at `t_s`, in the order of the scenario's `record`.
    fn record(&mut self, t_s: f64, values: &[L]);
    /// An event of one lane. Events of a lane come in order. Between lanes, and between events and records,
    /// the order within a sampling interval is not defined.
    fn event(&mut self, lane: usize, event: &Event);
}

/// An observer that ignores everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unobserved;

impl<L: Lane> Observer<L> for Unobserved {
    fn record(&mut self, _t_s: f64, _values: &[L]) {}
    fn event(&mut self, _lane: usize, _event: &Event) {}
}

/// Stores the complete record of a single variant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    pub names: Vec<String>,
    pub t_s: Vec<f64>,
    /// One column per signal.
    pub columns: Vec<Vec<f64>>,
    pub events: Vec<Event>,
}

impl Trace {
    /// An empty trace of these signals.
    pub fn new(names: &[String]) -> Self {
        Self {
            names: names.to_vec(),
            t_s: Vec::new(),
            columns: vec![Vec::new(); names.len()],
            events: Vec::new(),
        }
    }

    /// The values of a signal.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.names.iter().position(|n| n == name).map(|i| self.columns[i].as_slice())
    }
}

impl Observer<f64> for Trace {
    fn record(&mut self, t_s: f64, values: &[f64]) {
        self.t_s.push(t_s);
        for (column, value) in self.columns.iter_mut().zip(values) {
            column.push(*value);
        }
    }

    fn event(&mut self, _lane: usize, event: &Event) {
        self.events.push(*event);
    }
}
