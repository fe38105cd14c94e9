//! Options and result of an import.

use std::path::PathBuf;

use feeler_logs::ClockUnit;
use indexmap::IndexMap;

use super::axis::Model;
use super::guess::Guess;
use super::role::ColumnRole;
use super::summary::RunSummary;
use super::unpaired::Lead;

/// Statements of the user, which replace guesses.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Unit of all clocks.
    pub clock: Option<ClockUnit>,
    /// Rate of rows without a clock, Hz.
    pub rate_hz: Option<f64>,
    /// The only requested joint, by its name in the log or the model.
    pub joint: Option<String>,
    /// Columns by role.
    pub columns: Vec<(ColumnRole, String)>,
    /// Output folder; nothing is written without it.
    pub out: Option<PathBuf>,
    /// The believed machine.
    pub model: Option<Model>,
}

/// Contents of logs, and the datasets made from them.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// The runs.
    pub runs: Vec<RunSummary>,
    /// Joints, by their names in the log.
    pub joints: IndexMap<String, Guess>,
    /// Datasets that were written.
    pub datasets: Vec<Written>,
    /// Failures, a sentence each.
    pub notes: Vec<String>,
    /// Of a first run whose columns have no names, a column that follows another.
    pub(super) lead: Option<Lead>,
}

/// A dataset that was written.
#[derive(Clone, Debug)]
pub struct Written {
    /// Its folder.
    pub folder: PathBuf,
    /// The joint, by its name in the log.
    pub joint: String,
    /// Assumptions about the machine, a sentence each.
    pub assumptions: Vec<String>,
    /// Files of experiments.
    pub experiments: Vec<String>,
}
