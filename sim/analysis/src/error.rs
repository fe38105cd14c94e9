//! What can go wrong in the linear view of a machine.

use feeler_control::ControlError;
use feeler_engine::EngineError;
use feeler_lti::LtiError;
use feeler_plant::problem::Problem;
use thiserror::Error;

/// Why an analysis has no result.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum AnalysisError {
    /// The machine or its wiring has mistakes.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// A computation of linear theory failed.
    #[error(transparent)]
    Lti(#[from] LtiError),
    /// A controller's numbers are out of range.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// A signal does not exist.
    #[error("{problem}")]
    Signal {
        /// What is wrong with the name.
        problem: Problem,
    },
    /// A signal that is no linear function of the state, such as whether a contact touches.
    #[error("`{name}` is no linear function of the machine's state")]
    NotLinear {
        /// The signal.
        name: String,
    },
    /// The input of a linear analysis must be the command of an actuator or the force on a body.
    #[error(
        "`{name}` is no input: name an actuator's command, as in `drive.command`, or the force on a body, as in `tip.force`"
    )]
    NotAnInput {
        /// The signal.
        name: String,
    },
    /// No state of rest was found about which to linearise.
    #[error("no equilibrium was found: the forces left over give {residual_m_per_s2:.3e} m/s²")]
    NoEquilibrium {
        /// Largest acceleration that remains.
        residual_m_per_s2: f64,
    },
    /// A name that no controller has.
    #[error("there is no controller `{name}`")]
    NoController {
        /// What was asked for.
        name: String,
    },
    /// A gain that the control law does not have.
    #[error("a controller of law `{law}` has no gain `{key}`; it has {known}")]
    NoGain {
        /// The law.
        law: &'static str,
        /// What was asked for.
        key: String,
        /// What there is.
        known: String,
    },
    /// The periods of the controllers have no common multiple that is short enough to lift over.
    #[error("the controllers' periods repeat together only after more than {limit} samples of the fastest")]
    Rates {
        /// The most samples a common period may hold.
        limit: usize,
    },
    /// Delays so long that the sampled loop has too many states.
    #[error(
        "{stored} samples are under way in the delays of this loop, and {most} are the most (it repeats every {common_s} s)"
    )]
    LongDelay {
        /// Samples under way when a common period begins, each a state.
        stored: usize,
        /// The most there may be.
        most: usize,
        /// The period with which all controllers repeat.
        common_s: f64,
    },
    /// A loop that is broken at one controller is time-invariant only if nothing else repeats more slowly
    /// than this controller.
    #[error("`{name}` samples every {period_s} s, but the loop repeats only every {common_s} s")]
    SlowerThanLoop {
        /// The controller.
        name: String,
        /// Its period.
        period_s: f64,
        /// The period with which all controllers repeat.
        common_s: f64,
    },
    /// The continuous form of a law differentiates a signal that jumps with the command.
    #[error("the continuous form of `{name}` differentiates a signal that follows the command at once")]
    Improper {
        /// The controller.
        name: String,
    },
    /// Describing functions do not cover this machine.
    #[error("no prediction of limit cycles: {reason}")]
    NoLimitCycle {
        /// What is missing or in the way.
        reason: &'static str,
    },
    /// A measured response needs a record.
    #[error("the run ended at {t_s} s, before its record was complete")]
    RunEnded {
        /// When.
        t_s: f64,
    },
}

impl From<Problem> for AnalysisError {
    fn from(problem: Problem) -> Self {
        Self::Signal { problem }
    }
}
