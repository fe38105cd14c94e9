//! Errors of a validation, other than a check that fails.

use std::borrow::Cow;

use feeler_analysis::AnalysisError;
use feeler_engine::EngineError;
use feeler_lti::LtiError;
use feeler_problem::Remedy;
use thiserror::Error;

/// Why a check could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ValidationError {
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    #[error(transparent)]
    Lti(#[from] LtiError),
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error("this machine is not a chain that can be fitted: {what}")]
    Chain {
        /// The missing element, or the one that is not above zero.
        what: String,
    },
    #[error("the reference numbers are not readable: {what}")]
    Reference {
        /// The mistake, or its entry.
        what: String,
    },
}

impl Remedy for ValidationError {
    fn passed_on(&self) -> Option<&dyn Remedy> {
        match self {
            Self::Analysis(error) => Some(error),
            Self::Lti(error) => Some(error),
            Self::Engine(error) => Some(error),
            Self::Chain { .. } | Self::Reference { .. } => None,
        }
    }

    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Analysis(error) => error.remedy(),
            Self::Lti(error) => error.remedy(),
            Self::Engine(error) => error.remedy(),
            Self::Chain { .. } => {
                "start from a file that `feeler fit-landmarks --out FILE` wrote, its numbers changed, or \
                 without --start"
                    .into()
            }
            Self::Reference { .. } => {
                "name a file of the shape of reference/critical-gains.json with --critical-gains, or leave \
                 it out"
                    .into()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = [
            ValidationError::Analysis(AnalysisError::RunEnded { t_s: 0.1 }),
            ValidationError::Lti(LtiError::AlgebraicLoop),
            ValidationError::Engine(EngineError::Lanes { given: 3, lanes: 4 }),
            ValidationError::Chain { what: "a drive".into() },
            ValidationError::Reference { what: "it has no cases".into() },
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
