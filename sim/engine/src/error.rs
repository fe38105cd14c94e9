//! Errors in preparing or running a scenario.

use std::borrow::Cow;

use feeler_catalogue::Tabled;
use feeler_control::{ControlError, ControllerSpec};
use feeler_lti::LtiError;
use feeler_problem::{Problem, Remedy, in_lines};
use thiserror::Error;

/// Why a scenario cannot be prepared.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum EngineError {
    #[error("{}", in_lines(.problems))]
    Problems { problems: Vec<Problem> },
    #[error("controllers.{name}: {source}")]
    Control { name: String, source: ControlError },
    #[error("the equations of motion have no usable exponential: {0}")]
    Exponential(#[from] LtiError),
    #[error(
        "a part of the machine oscillates at {frequency_hz:.3e} Hz: \
         one second takes {evaluations_per_s:.1e} guard evaluations"
    )]
    TooFast { frequency_hz: f64, evaluations_per_s: f64 },
    #[error("variant {variant} differs from variant 0 in {what}")]
    Structure { variant: usize, what: &'static str },
    /// A run with an external body engine needs one engine per lane; any other run needs none.
    #[error("{given} engines that move bodies for {needed} variants that need one")]
    BodyEngines { given: usize, needed: usize },
    #[error("{given} scenarios for {lanes} lanes")]
    Lanes { given: usize, lanes: usize },
}

impl Remedy for EngineError {
    fn passed_on(&self) -> Option<&dyn Remedy> {
        match self {
            Self::Exponential(error) => Some(error),
            _ => None,
        }
    }

    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Problems { problems } => {
                problems.first().map_or("", |problem| problem.remedy.as_str()).into()
            }
            Self::Control { source, .. } => source.remedy(),
            Self::Exponential(error) => error.remedy(),
            Self::TooFast { .. } => {
                "find the body that is too light or the spring that is too stiff, and make it rigid".into()
            }
            Self::Structure { .. } => "run it in a batch of its own".into(),
            Self::BodyEngines { needed, .. } => format!("give {needed} such engines").into(),
            Self::Lanes { lanes, .. } => format!("give {lanes} scenarios").into(),
        }
    }

    fn place(&self) -> String {
        match self {
            Self::Problems { problems } => problems.first().map_or_else(String::new, |p| p.key.clone()),
            Self::Control { name, source } => {
                format!("{}.{}", ControllerSpec::place(name), source.place()).trim_end_matches('.').into()
            }
            Self::Exponential(error) => error.place(),
            Self::TooFast { .. } | Self::Structure { .. } | Self::BodyEngines { .. } | Self::Lanes { .. } => {
                String::new()
            }
        }
    }

    fn is_of_caller(&self) -> bool {
        match self {
            Self::Control { source, .. } => source.is_of_caller(),
            Self::Exponential(error) => error.is_of_caller(),
            Self::Structure { .. } | Self::BodyEngines { .. } | Self::Lanes { .. } => true,
            Self::Problems { .. } | Self::TooFast { .. } => false,
        }
    }

    fn problems(&self) -> Vec<Problem> {
        match self {
            Self::Problems { problems } => problems.clone(),
            Self::Control { source, .. } => {
                vec![Problem::new(self.place(), source.to_string(), source.remedy())]
            }
            _ => vec![Problem::new("", self.to_string(), self.remedy())],
        }
    }
}

/// End of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RunEnd {
    /// The run reached its duration.
    Completed,
    /// The motion left all bounds; the stored state is the last finite one.
    Diverged { t_s: f64 },
    /// More events than the limit at practically one instant, or endlessly short steps: the motion of the
    /// machine cannot be followed past this point.
    EventStorm { t_s: f64 },
    /// Removed from the run by [`crate::Simulation::stop`].
    Stopped { t_s: f64 },
}

impl RunEnd {
    /// Whether the run cannot continue. A run that has reached its duration can be extended.
    pub fn is_final(self) -> bool {
        self != Self::Completed
    }
}

#[cfg(test)]
mod tests {
    use feeler_catalogue::Bound;

    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = [
            EngineError::Problems {
                problems: vec![Problem::new("bodies", "nothing can move", "add a body that is free")],
            },
            EngineError::Control {
                name: "force".into(),
                source: ControlError::OutOfRange { key: "period".into(), value: 0.0, bound: Bound::Positive },
            },
            EngineError::Exponential(LtiError::NotFinite { quantity: "A" }),
            EngineError::TooFast { frequency_hz: 1e10, evaluations_per_s: 5e10 },
            EngineError::Structure { variant: 1, what: "its law" },
            EngineError::BodyEngines { given: 0, needed: 4 },
            EngineError::Lanes { given: 3, lanes: 4 },
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }

    #[test]
    fn truth_a_controllers_mistake_names_its_key() {
        let source = ControlError::OutOfRange { key: "period".into(), value: 0.0, bound: Bound::Positive };
        let error = EngineError::Control { name: "force".into(), source };
        assert_eq!(error.problems()[0].key, "controllers.force.period");
        let whole =
            EngineError::Control { name: "force".into(), source: ControlError::LawsDiffer { lane: 1 } };
        assert_eq!(whole.place(), "controllers.force");
    }
}
