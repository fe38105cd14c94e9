//! Why there is no frequency response.

use std::borrow::Cow;

use feeler_analysis::AnalysisError;
use feeler_problem::Remedy;
use thiserror::Error;

use crate::refusal::Refusal;

/// Why there is no frequency response.
#[derive(Debug, Error)]
pub enum FrfError {
    #[error(transparent)]
    Request(#[from] Refusal),
    /// The scenario or the dataset has the mistake; the caller knows its name.
    #[error("{0}")]
    Source(Refusal),
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
}

impl Remedy for FrfError {
    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Request(refusal) | Self::Source(refusal) => refusal.remedy(),
            Self::Analysis(AnalysisError::RunEnded { .. }) => {
                "the machine runs away under this excitation: try --clamped, or less with --rms".into()
            }
            Self::Analysis(AnalysisError::Lti(_)) => {
                "longer records, a shorter --segment or a narrower band may help".into()
            }
            Self::Analysis(error) => error.remedy(),
        }
    }
}

/// Rejects a request unless a condition holds.
///
/// # Errors
/// The refusal.
pub fn require(holds: bool, message: impl FnOnce() -> String, remedy: &str) -> Result<(), Refusal> {
    if holds { Ok(()) } else { Err(Refusal::new(message(), remedy)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let refusal = || Refusal::new("the band is empty", "widen it with --band");
        let all = [
            FrfError::Request(refusal()),
            FrfError::Source(refusal()),
            FrfError::Analysis(AnalysisError::RunEnded { t_s: 0.1 }),
            FrfError::Analysis(AnalysisError::NotLinear { name: "contact.touches".into() }),
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
