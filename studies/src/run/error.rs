//! Errors in running a scenario and writing its results.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use feeler_engine::EngineError;
use feeler_manipulator::ManipulatorError;
use feeler_problem::Remedy;
use parquet::errors::ParquetError;
use thiserror::Error;

use crate::unwritable::unwritable;

/// Why a run, or writing it, failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunError {
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error(transparent)]
    Manipulator(#[from] ManipulatorError),
    #[error("{}", unwritable(path, source).message)]
    Write { path: PathBuf, source: std::io::Error },
    #[error("{}: {source}", path.display())]
    Parquet { path: PathBuf, source: ParquetError },
    #[error("{}: {source}", path.display())]
    Csv { path: PathBuf, source: csv::Error },
}

impl RunError {
    pub(crate) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Write { path: path.into(), source }
    }

    pub(crate) fn parquet(path: &Path) -> impl FnOnce(ParquetError) -> Self {
        move |source| match system_error(source) {
            Ok(source) => Self::Write { path: path.into(), source },
            Err(source) => Self::Parquet { path: path.into(), source },
        }
    }

    pub(crate) fn csv(path: &Path) -> impl FnOnce(csv::Error) -> Self {
        move |source| Self::Csv { path: path.into(), source }
    }
}

/// The system's error, if a format's library passes one on.
pub(crate) fn system_error(source: ParquetError) -> Result<std::io::Error, ParquetError> {
    match source {
        ParquetError::External(inner) => {
            inner.downcast::<std::io::Error>().map(|inner| *inner).map_err(ParquetError::External)
        }
        other => Err(other),
    }
}

impl Remedy for RunError {
    fn passed_on(&self) -> Option<&dyn Remedy> {
        match self {
            Self::Engine(error) => Some(error),
            Self::Manipulator(error) => Some(error),
            _ => None,
        }
    }

    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Engine(error) => error.remedy(),
            Self::Manipulator(error) => error.remedy(),
            Self::Write { path, source } => unwritable(path, source).remedy.into(),
            Self::Parquet { .. } | Self::Csv { .. } => {
                "remove the file, and name a place that can be written".into()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind;

    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let path = || PathBuf::from("out/trace");
        let all = [
            RunError::Engine(EngineError::Lanes { given: 3, lanes: 4 }),
            RunError::Manipulator(ManipulatorError::NeverMeets),
            RunError::Write { path: path(), source: ErrorKind::StorageFull.into() },
            RunError::Write { path: path(), source: ErrorKind::PermissionDenied.into() },
            RunError::Parquet { path: path(), source: ParquetError::EOF("cut off".into()) },
            RunError::Csv { path: path(), source: std::io::Error::from(ErrorKind::BrokenPipe).into() },
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
