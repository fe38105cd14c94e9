//! What can go wrong in a validation, other than a check that fails.

use feeler_analysis::AnalysisError;
use feeler_engine::EngineError;
use feeler_lti::LtiError;
use thiserror::Error;

/// Why a check could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ValidationError {
    /// The linear view of a machine failed.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// A computation of linear theory failed.
    #[error(transparent)]
    Lti(#[from] LtiError),
    /// A run could not be prepared.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// A machine is no chain of the kind that is fitted to the paper's landmarks.
    #[error("this machine is not of the fitted chain's kind: {what}")]
    Chain {
        /// What is missing or not above zero.
        what: String,
    },
    /// Reference numbers are not of the shape that is expected.
    #[error("the reference numbers are not readable: {what}")]
    Reference {
        /// What is wrong, or the entry that is.
        what: String,
    },
}
