//! Errors in reading a log.

use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};

use feeler_problem::Remedy;
use thiserror::Error;

/// Place of a mistake in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LogPlace {
    /// A byte, counted from zero.
    Byte(u64),
    /// A row, counted from one.
    Row(usize),
    /// A byte of a message of a topic, both counted from zero.
    Message {
        topic: String,
        /// Previous messages of the topic.
        number: usize,
        /// Byte of the message.
        byte: usize,
    },
    /// A byte of one array of an archive.
    Array {
        name: String,
        /// Byte of its file.
        byte: u64,
    },
}

impl fmt::Display for LogPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Row(row) => write!(f, "row {row}"),
            Self::Message { topic, number, byte } => {
                write!(f, "message {number} of {topic}, byte {byte}")
            }
            Self::Array { name, byte } => write!(f, "array `{name}`, byte {byte}"),
        }
    }
}

/// Why a log cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LogError {
    /// The file cannot be opened.
    #[error("{}: {source}", .file.display())]
    Open {
        file: PathBuf,
        /// The answer of the system.
        source: std::io::Error,
    },
    /// The file is not a log, or a log of an unsupported kind.
    #[error("{}: {what}", .file.display())]
    OtherSort { file: PathBuf, what: String, remedy: Cow<'static, str> },
    /// The file ends early, or its bytes violate its format.
    #[error("{}: {place}: {what}", .file.display())]
    Damaged { file: PathBuf, place: LogPlace, what: String, remedy: &'static str },
    /// A requested column does not exist.
    #[error("{}: there is no column `{name}`", .file.display())]
    NoColumn {
        file: PathBuf,
        name: String,
        /// A similar column, or the columns of the file.
        remedy: String,
    },
}

/// Remedy for a file that cannot be opened.
const NOT_THERE: &str = "check the name of the file, and that you may read it";

impl LogError {
    pub(crate) fn open(file: &Path) -> impl FnOnce(std::io::Error) -> Self + use<> {
        let file = file.to_owned();
        move |source| Self::Open { file, source }
    }

    pub(crate) fn damaged(
        file: &Path,
        place: LogPlace,
        what: impl Into<String>,
        remedy: &'static str,
    ) -> Self {
        Self::Damaged { file: file.to_owned(), place, what: what.into(), remedy }
    }

    pub(crate) fn other(file: &Path, what: impl Into<String>, remedy: impl Into<Cow<'static, str>>) -> Self {
        Self::OtherSort { file: file.to_owned(), what: what.into(), remedy: remedy.into() }
    }

    /// The file in question.
    pub fn file(&self) -> &Path {
        match self {
            Self::Open { file, .. }
            | Self::OtherSort { file, .. }
            | Self::Damaged { file, .. }
            | Self::NoColumn { file, .. } => file,
        }
    }
}

impl Remedy for LogError {
    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Open { .. } => NOT_THERE.into(),
            Self::OtherSort { remedy, .. } => remedy.as_ref().into(),
            Self::Damaged { remedy, .. } => (*remedy).into(),
            Self::NoColumn { remedy, .. } => remedy.as_str().into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let file = Path::new("bag.mcap");
        let all = [
            LogError::open(file)(std::io::ErrorKind::NotFound.into()),
            LogError::other(file, "this is a PDF", "name a log"),
            LogError::damaged(file, LogPlace::Byte(7), "the file ends here", "record it again"),
            LogError::NoColumn {
                file: file.into(),
                name: "q".into(),
                remedy: "`feeler import` lists the columns".into(),
            },
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
        let places = [
            LogPlace::Row(3),
            LogPlace::Message { topic: "/a".into(), number: 2, byte: 9 },
            LogPlace::Array { name: "q".into(), byte: 4 },
        ];
        assert_eq!(
            places.map(|place| place.to_string()),
            ["row 3", "message 2 of /a, byte 9", "array `q`, byte 4"]
        );
    }
}
