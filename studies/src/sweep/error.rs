//! What can go wrong in a sweep as a whole; what goes wrong in a variant is its row.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::run::system_error;
use feeler_files::FormatError;

/// Why a sweep, or putting its results together, failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The sweep file or its scenario has mistakes.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A Parquet file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What the format's library says.
        source: parquet::errors::ParquetError,
    },
    /// A file of results does not hold what its sweep's files hold.
    #[error("{}: there is no column `{column}` of the kind expected", path.display())]
    Column {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
    },
    /// The folder holds results of another sweep.
    #[error("{} holds results of another sweep, or of this one before its files changed", folder.display())]
    OtherSweep {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder to be merged holds no sweep.
    #[error("{} holds no sweep", folder.display())]
    NoSweep {
        /// The folder.
        folder: PathBuf,
    },
    /// Not all shards are there.
    #[error("{missing} of {chunks} chunks are missing, the first of them chunk {first}")]
    Incomplete {
        /// How many chunks are missing.
        missing: usize,
        /// How many there are in all.
        chunks: usize,
        /// The first that is missing.
        first: usize,
    },
    /// An adaptive sweep cannot be cut into shards.
    #[error("a sweep with [refine] cannot be cut into shards, since each pass follows from the one before")]
    RefineShard,
    /// No threads to be had.
    #[error("threads cannot be started: {source}")]
    Threads {
        /// What the thread pool says.
        source: rayon::ThreadPoolBuildError,
    },
}

impl SweepError {
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Io { path: path.into(), source }
    }

    pub(crate) fn parquet(path: &Path) -> impl FnOnce(parquet::errors::ParquetError) -> Self {
        // What the system says while a file is written has nothing to do with its format.
        move |source| match system_error(source) {
            Ok(source) if matches!(source.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded) => {
                Self::Io { path: path.into(), source }
            }
            Ok(source) => Self::Parquet { path: path.into(), source: source.into() },
            Err(source) => Self::Parquet { path: path.into(), source },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::errors::ParquetError;

    #[test]
    fn regress_a_full_disk_is_no_mistake_of_a_table() {
        let of = |kind: ErrorKind| {
            SweepError::parquet(Path::new("sweep.parquet"))(ParquetError::from(std::io::Error::from(kind)))
        };
        assert!(matches!(of(ErrorKind::StorageFull), SweepError::Io { .. }));
        assert!(matches!(of(ErrorKind::UnexpectedEof), SweepError::Parquet { .. }));
    }
}
