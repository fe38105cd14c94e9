//! Why there is no frequency response.

use feeler_analysis::AnalysisError;
use thiserror::Error;

use crate::refusal::Refusal;

/// Why there is no frequency response.
#[derive(Debug, Error)]
pub enum FrfError {
    /// The request is at fault.
    #[error(transparent)]
    Request(#[from] Refusal),
    /// The scenario or the dataset is at fault; whoever read it knows its name.
    #[error("{0}")]
    Source(Refusal),
    /// Simulation or estimation failed.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
}

impl FrfError {
    /// What to do about it.
    pub fn remedy(&self) -> &str {
        match self {
            Self::Request(refusal) | Self::Source(refusal) => &refusal.remedy,
            Self::Analysis(AnalysisError::RunEnded { .. }) => {
                "the machine runs away under this excitation: try --clamped, or less with --rms"
            }
            Self::Analysis(AnalysisError::Lti(_)) => {
                "longer records, a shorter --segment or a narrower band may help"
            }
            Self::Analysis(_) => "see feeler frf --help for what can be asked",
        }
    }
}

/// Refuses a request unless a condition holds.
///
/// # Errors
/// The refusal.
pub fn require(holds: bool, message: impl FnOnce() -> String, remedy: &str) -> Result<(), Refusal> {
    if holds { Ok(()) } else { Err(Refusal::new(message(), remedy)) }
}
