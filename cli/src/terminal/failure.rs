//! Failures: text for people, and the exit code for programs.

use std::borrow::Cow;
use std::fmt;
use std::path::Path;
use std::process::ExitCode;

use feeler_problem::{Problem, Remedy};
use feeler_studies::unwritable;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::stderr;

/// All went well.
pub(crate) const DONE: u8 = 0;
/// A check failed.
pub(crate) const CHECK_FAILED: u8 = 1;
/// The input has a mistake, or the output cannot be written.
pub(crate) const BAD_INPUT: u8 = 2;
/// A mistake of the program.
pub(crate) const INTERNAL: u8 = 3;

/// Text for an error of the program.
const REPORT_IT: &str = "this is a bug in feeler; please report it with the file";

/// The result of a command, or the failure that ended it.
pub(crate) type Result<T> = std::result::Result<T, Failure>;

/// Reason why a command ends early. An error reaches the terminal only with its remedy.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A mistake that the user can correct, unless the error names the program as its cause.
    Mistake(Box<dyn Remedy>),
    /// A mistake of the program.
    Internal(String),
    /// A check has failed; the table shows which one.
    CheckFailed,
    /// The failure has been reported; only the exit code remains.
    Reported,
    /// The reader of the output has closed it.
    Unheard,
}

impl<E: Remedy + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Mistake(Box::new(error))
    }
}

impl Failure {
    /// A failure that no input can cause.
    pub(crate) fn internal(error: impl fmt::Display) -> Self {
        Self::Internal(error.to_string())
    }

    /// Prints the failure and returns its exit code.
    pub(crate) fn report(&self) -> ExitCode {
        let (text, code) = match self {
            Self::Unheard => return ExitCode::from(DONE),
            Self::Reported => return ExitCode::from(BAD_INPUT),
            Self::CheckFailed => return ExitCode::from(CHECK_FAILED),
            Self::Internal(message) => (format!("error: {message}\n  help: {REPORT_IT}"), INTERNAL),
            Self::Mistake(error) if error.is_of_caller() => {
                (format!("error: {error}\n  help: {REPORT_IT}"), INTERNAL)
            }
            Self::Mistake(error) => (error.report(stderr::has_colours()), BAD_INPUT),
        };
        stderr::complain(&text);
        ExitCode::from(code)
    }
}

/// Bad input, with its remedy.
#[derive(Debug)]
pub(crate) struct BadInput(Problem);

impl BadInput {
    pub(crate) fn error(message: impl Into<String>, remedy: impl Into<String>) -> Failure {
        Self(Problem::new("", message, remedy)).into()
    }

    /// A file or folder that cannot be written.
    pub(crate) fn unwritable(path: &Path, source: &std::io::Error) -> Failure {
        Self(unwritable(path, source)).into()
    }
}

/// This many threads; 0 stands for one per processor.
pub(crate) fn pool(threads: usize) -> Result<ThreadPool> {
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| {
        BadInput::error(
            format!("threads cannot be started: {error}"),
            "allow the process more threads, or set RAYON_NUM_THREADS to fewer",
        )
    })
}

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.message)
    }
}

impl std::error::Error for BadInput {}

impl Remedy for BadInput {
    fn remedy(&self) -> Cow<'_, str> {
        self.0.remedy.as_str().into()
    }
}
