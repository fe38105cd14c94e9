//! Errors of a sweep as a whole; those of a variant are in its row.

use std::borrow::Cow;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use feeler_problem::Remedy;
use thiserror::Error;

use crate::run::system_error;
use crate::unwritable::unwritable;
use feeler_files::FormatError;

/// Why a sweep, or the assembly of its results, failed.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the message of an error says what its fields are")]
pub enum SweepError {
    /// The sweep file or its scenario has mistakes.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A file cannot be read or written.
    #[error("{}", unwritable(path, source).message)]
    Io { path: PathBuf, source: std::io::Error },
    /// A Parquet file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Parquet { path: PathBuf, source: parquet::errors::ParquetError },
    /// A file of results does not match its sweep's files.
    #[error("{}: there is no column `{column}` of the expected kind", path.display())]
    Column { path: PathBuf, column: String },
    /// The folder holds results of another sweep.
    #[error("{} holds results of another sweep, or of this one before its files changed", folder.display())]
    OtherSweep { folder: PathBuf },
    /// A folder to be merged holds no sweep.
    #[error("{} holds no sweep", folder.display())]
    NoSweep { folder: PathBuf },
    /// Not all shards are there.
    #[error("{missing} of {chunks} chunks are missing, the first of them chunk {first}")]
    Incomplete {
        /// How many chunks are missing.
        missing: usize,
        /// Their total number.
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
        /// Message of the thread pool.
        source: rayon::ThreadPoolBuildError,
    },
}

impl Remedy for SweepError {
    fn passed_on(&self) -> Option<&dyn Remedy> {
        match self {
            Self::Format(error) => Some(error),
            _ => None,
        }
    }

    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Format(error) => error.remedy(),
            Self::Io { path, source } => unwritable(path, source).remedy.into(),
            Self::Parquet { .. } | Self::Column { .. } => {
                "remove the file: what is missing is run again".into()
            }
            Self::OtherSweep { .. } => "name another folder with --out, or remove this one".into(),
            Self::NoSweep { .. } => "name the folder that `feeler sweep --out` was given".into(),
            Self::Incomplete { .. } => "run the shards that have not ended, or name their folders too".into(),
            Self::RefineShard => "run it on one machine, or remove [refine]".into(),
            Self::Threads { .. } => "allow more threads, or set RAYON_NUM_THREADS to fewer".into(),
        }
    }

    fn place(&self) -> String {
        match self {
            Self::RefineShard => "refine".into(),
            _ => self.passed_on().map_or_else(String::new, Remedy::place),
        }
    }
}

impl SweepError {
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Io { path: path.into(), source }
    }

    pub(crate) fn parquet(path: &Path) -> impl FnOnce(parquet::errors::ParquetError) -> Self {
        // System errors during writing are independent of the format.
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
    fn prop_every_error_says_what_to_do() {
        let wrong = feeler_files::Document::parse("mass = = 3", "a.toml").map(drop);
        let path = || PathBuf::from("out/sweep.parquet");
        let too_many = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .spawn_handler(|_| Err(ErrorKind::OutOfMemory.into()))
            .build()
            .err();
        let all: Vec<SweepError> = (wrong.err().map(SweepError::Format).into_iter())
            .chain(too_many.map(|source| SweepError::Threads { source }))
            .chain([
                SweepError::Io { path: path(), source: ErrorKind::StorageFull.into() },
                SweepError::Io { path: path(), source: ErrorKind::PermissionDenied.into() },
                SweepError::Parquet { path: path(), source: ParquetError::EOF("cut off".into()) },
                SweepError::Column { path: path(), column: "kp".into() },
                SweepError::OtherSweep { folder: path() },
                SweepError::NoSweep { folder: path() },
                SweepError::Incomplete { missing: 1, chunks: 2, first: 1 },
                SweepError::RefineShard,
            ])
            .collect();
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }

    #[test]
    fn regress_a_full_disk_is_no_mistake_of_a_table() {
        let of = |kind: ErrorKind| {
            SweepError::parquet(Path::new("sweep.parquet"))(ParquetError::from(std::io::Error::from(kind)))
        };
        assert!(matches!(of(ErrorKind::StorageFull), SweepError::Io { .. }));
        assert!(matches!(of(ErrorKind::UnexpectedEof), SweepError::Parquet { .. }));
    }
}
