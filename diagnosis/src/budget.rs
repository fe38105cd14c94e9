//! The time that a diagnosis may take.
//!
//! Every stage leaves what it has not tried when its share of the time is spent, so that the answer still
//! comes within the whole. What was left is named in the answer.

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
    /// Accepted causes are fitted again, together or one without the other, and the next experiment is looked
    /// for.
    Compose,
}

impl Stage {
    /// Share of the whole time at which it ends. What comes after it takes about as long as one step of a fit
    /// over all records. A diagnosis takes some dozens of these steps.
    fn ends_at(self) -> f64 {
        match self {
            Self::Calibrate => 0.15,
            Self::Screen => 0.5,
            Self::Fit => 0.65,
            Self::Compose => 0.8,
        }
    }
}

impl Budget {
    /// This much from now on.
    pub fn of(limit: Duration) -> Self {
        Self { begun: Instant::now(), limit: Some(limit) }
    }

    /// As long as it takes: answers do not depend on how fast the computer is.
    pub fn unlimited() -> Self {
        Self { begun: Instant::now(), limit: None }
    }

    pub(crate) fn is_over(&self, stage: Stage) -> bool {
        self.limit.is_some_and(|limit| self.begun.elapsed() >= limit.mul_f64(stage.ends_at()))
    }
}
