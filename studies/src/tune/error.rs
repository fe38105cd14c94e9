//! Why a controller could not be tuned.

use std::borrow::Cow;

use feeler_analysis::AnalysisError;
use feeler_files::FormatError;
use feeler_problem::Remedy;
use thiserror::Error;

use crate::refusal::Refusal;
use crate::run::RunError;

/// Why a controller could not be tuned.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TuneError {
    #[error(transparent)]
    Refused(#[from] Refusal),
    #[error(transparent)]
    Format(#[from] FormatError),
    #[error(transparent)]
    Run(#[from] RunError),
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
}

impl TuneError {
    fn inner(&self) -> &dyn Remedy {
        match self {
            Self::Refused(error) => error,
            Self::Format(error) => error,
            Self::Run(error) => error,
            Self::Analysis(error) => error,
        }
    }
}

impl Remedy for TuneError {
    fn passed_on(&self) -> Option<&dyn Remedy> {
        Some(self.inner())
    }

    fn remedy(&self) -> Cow<'_, str> {
        self.inner().remedy()
    }
}

pub(super) fn refused(message: impl Into<String>, remedy: impl Into<String>) -> TuneError {
    Refusal::new(message, remedy).into()
}

#[cfg(test)]
mod tests {
    use feeler_engine::EngineError;
    use feeler_files::Document;

    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = [
            refused("no gains were tried", "widen the limits on gains"),
            Document::parse("mass = = 3", "a.toml").unwrap_err().into(),
            RunError::Engine(EngineError::Lanes { given: 3, lanes: 4 }).into(),
            AnalysisError::NoController { name: "force".into(), known: Vec::new() }.into(),
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
