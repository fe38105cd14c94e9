//! The largest contact force of a run, which checks every row of every comparison.

use feeler_engine::{EngineError, Event, Observer, Program, Scenario, Simulation};
use feeler_lanes::Lane;

/// Largest and last value of the first recorded signal, lane by lane.
#[derive(Clone, Debug, PartialEq)]
pub struct Peak<L> {
    /// Largest value.
    pub largest: L,
    /// Last value.
    pub last: L,
    /// Events seen.
    pub events: u64,
}

impl<L: Lane> Default for Peak<L> {
    fn default() -> Self {
        Self { largest: L::splat(f64::NEG_INFINITY), last: L::zero(), events: 0 }
    }
}

impl<L: Lane> Observer<L> for Peak<L> {
    fn record(&mut self, _t_s: f64, values: &[L]) {
        self.largest = self.largest.max(values[0]);
        self.last = values[0];
    }

    fn event(&mut self, _lane: usize, _event: &Event) {
        self.events += 1;
    }
}

/// Runs one variant and gives the peak of its first recorded signal.
///
/// # Errors
/// Those of [`Program::new`] and [`Simulation::run`].
pub fn peak_of(scenario: &Scenario) -> Result<Peak<f64>, EngineError> {
    let mut peak = Peak::default();
    Simulation::<f64>::new(vec![Program::new(scenario)?])?.run(&mut peak)?;
    Ok(peak)
}
