//! What can go wrong in running a scenario and writing what it gave.

use std::path::{Path, PathBuf};

use feeler_engine::EngineError;
use feeler_manipulator::ManipulatorError;
use parquet::errors::ParquetError;
use thiserror::Error;

/// Why a run, or writing it, failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunError {
    /// The scenario cannot be run.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The arm, its tool and its workpiece cannot be run.
    #[error(transparent)]
    Manipulator(#[from] ManipulatorError),
    /// A file cannot be written.
    #[error("{}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A trace cannot be put into Parquet.
    #[error("{}: {source}", path.display())]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What the format's library says.
        source: ParquetError,
    },
    /// A trace cannot be put into CSV.
    #[error("{}: {source}", path.display())]
    Csv {
        /// The file.
        path: PathBuf,
        /// What the format's library says.
        source: csv::Error,
    },
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

/// What the system said, where that is what a format's library passes on.
pub(crate) fn system_error(source: ParquetError) -> Result<std::io::Error, ParquetError> {
    match source {
        ParquetError::External(inner) => {
            inner.downcast::<std::io::Error>().map(|inner| *inner).map_err(ParquetError::External)
        }
        other => Err(other),
    }
}
