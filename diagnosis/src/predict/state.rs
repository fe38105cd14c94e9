//! State of a machine along a record, with the states of its control loops.

use std::collections::VecDeque;

use feeler_control::{Controller, ControllerSpec};
use feeler_problem::{Problem, Remedy};

use crate::error::DiagnosisError;

/// State and mode of a machine.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub(super) xi: Vec<f64>,
    pub(super) flow: usize,
    /// The loops of sampled servos.
    pub(super) loops: Vec<LoopState>,
}

#[derive(Clone, Debug)]
pub(super) struct LoopState {
    pub(super) controller: Controller<f64>,
    pub(super) target: f64,
    pub(super) followed: f64,
    /// Largest rate of `followed`, m/s.
    pub(super) pace: f64,
    /// Forces of the other inputs that have arrived, by their drives.
    pub(super) fed: Vec<(usize, f64)>,
    pub(super) samples: u64,
    /// Delayed outputs: their times of arrival and values.
    pub(super) pending: VecDeque<(f64, f64)>,
    /// For each sensor, the signals stored for later samples, and the number stored so far.
    pub(super) taken: [(VecDeque<f64>, u64); 2],
}

impl LoopState {
    pub(super) fn of(spec: ControllerSpec, stands: f64, key: &str) -> Result<Self, DiagnosisError> {
        let controller = Controller::new(&[spec]).map_err(|error| DiagnosisError::Machine {
            problems: vec![Problem::new(key, error.to_string(), error.remedy())],
        })?;
        let pending = VecDeque::new();
        let taken = [(VecDeque::new(), 0), (VecDeque::new(), 0)];
        let fed = Vec::new();
        let pace = f64::INFINITY;
        Ok(Self { controller, target: stands, followed: stands, pace, fed, samples: 0, pending, taken })
    }
}
