//! Errors of the linear analysis of a machine.

use std::borrow::Cow;

use feeler_control::ControlError;
use feeler_engine::EngineError;
use feeler_lti::LtiError;
use feeler_plant::description::Actuator;
use feeler_problem::{Problem, Remedy};
use thiserror::Error;

/// The reason why an analysis has no result.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum AnalysisError {
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error(transparent)]
    Lti(#[from] LtiError),
    #[error(transparent)]
    Control(#[from] ControlError),
    #[error("{}", problem.headline())]
    Signal { problem: Problem },
    /// The signal is not a linear function of the state: for example, whether a contact touches.
    #[error("`{name}` is not a linear function of the machine's state")]
    NotLinear { name: String },
    #[error("`{name}` is not an input")]
    NotAnInput { name: String },
    #[error("no equilibrium was found: the remaining forces give {residual_m_per_s2:.3e} m/s²")]
    NoEquilibrium { residual_m_per_s2: f64 },
    #[error("there is no controller `{name}`")]
    NoController { name: String, known: Vec<String> },
    /// The loop of a continuous servo is part of the machine. A servo loop can be broken only at its samples.
    #[error("the servo `{name}` has no period, so its loop cannot be broken")]
    ContinuousServo { name: String },
    /// A controller closes a loop around the loop of a sampled servo, or drives an input besides its target.
    #[error("`{name}` acts through the sampled servo `{servo}`, which linear theory does not follow")]
    Cascade { name: String, servo: String },
    #[error("a controller of law `{law}` has no gain `{key}`")]
    NoGain { law: &'static str, key: String, known: String },
    /// The common period of the controllers is too long for a lifted model.
    #[error("the controllers' periods repeat together only after more than {limit} samples of the fastest")]
    Rates { limit: usize },
    #[error(
        "the delays of this loop hold {stored} samples, more than the limit of {most} (it repeats every \
         {common_s} s)"
    )]
    LongDelay {
        /// Samples in transit when a common period begins. Each is a state.
        stored: usize,
        most: usize,
        common_s: f64,
    },
    /// A loop broken at one controller is time-invariant only if no other controller repeats more slowly.
    #[error("`{name}` samples every {period_s} s, but the loop repeats only every {common_s} s")]
    SlowerThanLoop { name: String, period_s: f64, common_s: f64 },
    #[error("the continuous form of `{name}` differentiates a signal that follows the command at once")]
    Improper { name: String },
    #[error("this output follows derivatives of the position that `{name}` imposes")]
    ImposedOutput { name: String },
    /// Describing functions do not cover this machine.
    #[error("limit cycles cannot be predicted: {reason}")]
    NoLimitCycle { reason: &'static str },
    #[error("the run ended at {t_s} s, before its record was complete")]
    RunEnded { t_s: f64 },
}

impl Remedy for AnalysisError {
    fn passed_on(&self) -> Option<&dyn Remedy> {
        match self {
            Self::Engine(error) => Some(error),
            Self::Lti(error) => Some(error),
            Self::Control(error) => Some(error),
            _ => None,
        }
    }

    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Engine(error) => error.remedy(),
            Self::Lti(error) => error.remedy(),
            Self::Control(error) => error.remedy(),
            Self::Signal { problem } => problem.remedy.as_str().into(),
            Self::NotLinear { .. } => "name a position, velocity, acceleration or force".into(),
            Self::NotAnInput { .. } => {
                "name an actuator's command, as in `drive.command`, or the force on a body, as in `tip.force`"
                    .into()
            }
            Self::NoEquilibrium { .. } => {
                "linearise about another force, or balance the forces of the file at rest".into()
            }
            Self::NoController { known, .. } if known.is_empty() => {
                "add a controller: the file has none".into()
            }
            Self::NoController { known, .. } => format!("name the controller {}", known.join(" or ")).into(),
            Self::ContinuousServo { name } => {
                format!("state `{}`, or sweep its gain", Actuator::SERVO_PERIOD.of(name)).into()
            }
            Self::Cascade { servo, .. } => {
                format!("leave out `{}`: its loop is then continuous", Actuator::SERVO_PERIOD.of(servo))
                    .into()
            }
            Self::NoGain { known, .. } => format!("name one of {known}").into(),
            Self::Rates { .. } => "make the period of one a multiple of the other's".into(),
            Self::LongDelay { .. } => "shorten the delay, or lengthen the period of the controller".into(),
            Self::SlowerThanLoop { name, .. } => {
                format!("break the loop at the slowest controller in place of `{name}`").into()
            }
            Self::Improper { .. } => {
                "read a signal that follows the command later, or leave the derivative out".into()
            }
            Self::ImposedOutput { .. } => {
                "name a position as the output, or measure this signal by `feeler frf`".into()
            }
            Self::NoLimitCycle { .. } => "run the scenario, or analyse it without the effects".into(),
            Self::RunEnded { .. } => "excite the machine less, or hold it".into(),
        }
    }
}

impl From<Problem> for AnalysisError {
    fn from(problem: Problem) -> Self {
        Self::Signal { problem }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let name = || "force".to_owned();
        let all = [
            AnalysisError::Engine(EngineError::Lanes { given: 3, lanes: 4 }),
            AnalysisError::Lti(LtiError::AlgebraicLoop),
            AnalysisError::Control(ControlError::ApproachNeedsForce),
            AnalysisError::Signal { problem: Problem::new("", "there is no `x`", "did you mean `y`?") },
            AnalysisError::NotLinear { name: name() },
            AnalysisError::NotAnInput { name: name() },
            AnalysisError::NoEquilibrium { residual_m_per_s2: 1.0 },
            AnalysisError::NoController { name: name(), known: Vec::new() },
            AnalysisError::ContinuousServo { name: name() },
            AnalysisError::NoController { name: name(), known: vec!["press".into()] },
            AnalysisError::NoGain { law: "position", key: "kx".into(), known: "kp, kd".into() },
            AnalysisError::Cascade { name: name(), servo: "joint".into() },
            AnalysisError::Rates { limit: 1000 },
            AnalysisError::LongDelay { stored: 3000, most: 2000, common_s: 1e-3 },
            AnalysisError::SlowerThanLoop { name: name(), period_s: 1e-3, common_s: 2e-3 },
            AnalysisError::Improper { name: name() },
            AnalysisError::ImposedOutput { name: name() },
            AnalysisError::NoLimitCycle { reason: "the loop does not oscillate" },
            AnalysisError::RunEnded { t_s: 0.1 },
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
