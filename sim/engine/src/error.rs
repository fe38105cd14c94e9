//! What can go wrong in preparing or running a scenario.

use feeler_control::ControlError;
use feeler_lti::LtiError;
use feeler_plant::problem::Problem;
use thiserror::Error;

/// Why a scenario cannot be prepared.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum EngineError {
    /// The machine or its wiring has mistakes.
    #[error("{}", list(.problems))]
    Problems {
        /// Every mistake, by key.
        problems: Vec<Problem>,
    },
    /// A controller's numbers are out of range.
    #[error("controllers.{name}: {source}")]
    Control {
        /// The controller.
        name: String,
        /// What is wrong.
        source: ControlError,
    },
    /// The matrix exponential of a mode failed.
    #[error("the equations of motion have no usable exponential: {0}")]
    Exponential(#[from] LtiError),
    /// Variants that shall run side by side differ in more than numbers.
    #[error("variant {variant} differs from variant 0 in {what}; run it in a batch of its own")]
    Structure {
        /// Index of the variant.
        variant: usize,
        /// What differs.
        what: &'static str,
    },
    /// A run whose bodies another engine shall move needs one such engine per lane, and any other run none.
    #[error("{given} engines that move bodies for {needed} variants that need one")]
    BodyEngines {
        /// How many were given.
        given: usize,
        /// How many are needed.
        needed: usize,
    },
    /// A batch needs one scenario per lane.
    #[error("{given} scenarios for {lanes} lanes")]
    Lanes {
        /// How many were given.
        given: usize,
        /// How many lanes there are.
        lanes: usize,
    },
}

fn list(problems: &[Problem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum RunEnd {
    /// At its duration.
    Completed,
    /// The motion left all bounds; the state kept is the last finite one.
    Diverged {
        /// When.
        t_s: f64,
    },
    /// More events than the limit at practically one instant: the machine as described has no motion past it.
    EventStorm {
        /// When.
        t_s: f64,
    },
    /// Taken out of the run by [`crate::Simulation::stop`].
    Stopped {
        /// When.
        t_s: f64,
    },
}
