//! The time that a diagnosis may take.
//!
//! Every stage skips its remaining trials when its share of the time is spent, so that the answer comes in
//! time. The answer names the causes that were skipped.

use std::time::{Duration, Instant};

/// Wall time that a diagnosis may take, counted from its creation.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    begun: Instant,
    limit: Option<Duration>,
}

/// Stages of a diagnosis that are cut short when their part of the time is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Believed values are fitted further.
    Calibrate,
    /// Further candidates are fitted for a few steps.
    Screen,
    /// Candidates are fitted to the end.
    Fit,
    /// Accepted causes are fitted again, together and with one left out, and the next experiment is designed.
    Compose,
    /// Machines run freely over the check experiments, to machine precision.
    RunFreely,
    /// The check experiments are predicted for reports.
    Report,
}

impl Stage {
    /// Share of the time limit at which the stage ends. The work after a stage takes about as long as one
    /// fitting step over all records. A diagnosis takes some dozens of such steps.
    fn ends_at(self) -> f64 {
        match self {
            Self::Calibrate => 0.15,
            Self::Screen => 0.6,
            Self::Fit => 0.75,
            Self::Compose => 0.88,
            Self::RunFreely => 0.95,
            Self::Report => 1.0,
        }
    }
}

impl Budget {
    /// A limit, counted from now.
    pub fn of(limit: Duration) -> Self {
        Self { begun: Instant::now(), limit: Some(limit) }
    }

    /// No limit: answers do not depend on the speed of the computer.
    pub fn unlimited() -> Self {
        Self { begun: Instant::now(), limit: None }
    }

    pub(crate) fn is_over(&self, stage: Stage) -> bool {
        self.limit.is_some_and(|limit| self.begun.elapsed() >= limit.mul_f64(stage.ends_at()))
    }
}
