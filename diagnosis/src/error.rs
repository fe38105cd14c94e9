//! What stops a diagnosis.

use std::path::PathBuf;

use feeler_files::FormatError;
use feeler_lti::LtiError;
use feeler_plant::problem::Problem;
use thiserror::Error;

/// Why there is no diagnosis.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DiagnosisError {
    /// The dataset file or the machine that it names has mistakes.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A file cannot be read.
    #[error("{}: {source}", .file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: csv::Error,
    },
    /// A file that is not what its ending says.
    #[error("{}: {reason}", .file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        reason: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A fault of the measured series that no assumption can repair.
    #[error("{}", list_faults(.faults))]
    Data {
        /// Every fault found.
        faults: Vec<crate::dataset::fault::Fault>,
    },
    /// A column stands for a signal that the machine to be replayed has not.
    #[error("column `{column}` is `{signal}`, which this machine has not: {reason}")]
    Signal {
        /// The column.
        column: String,
        /// What it stands for.
        signal: String,
        /// What the machine has instead.
        reason: String,
    },
    /// There is nothing to fit, or nothing to check it on.
    #[error(
        "a diagnosis fits some experiments and checks on others: here {fitted} are to be fitted and {checked} to be checked on (record one more, or give the experiments `role = \"fit\"` and `role = \"check\"`)"
    )]
    Roles {
        /// Experiments to be fitted.
        fitted: usize,
        /// Experiments to be checked on.
        checked: usize,
    },
    /// The believed machine's prediction of the records has no finite size.
    #[error(
        "the believed machine predicts no finite motion over these records, whose rows are {spacing_s} s apart (is the time in seconds? are commands in N, or m/s?)"
    )]
    Unbounded {
        /// Spacing of rows, s.
        spacing_s: f64,
    },
    /// The machine has no motion as it stands.
    #[error("the machine cannot be moved: {}", list_problems(.problems))]
    Machine {
        /// Every mistake, by key.
        problems: Vec<Problem>,
    },
    /// A mode of the machine has no usable exponential.
    #[error("the equations of motion have no usable exponential: {0}")]
    Exponential(#[from] LtiError),
}

fn list_faults(faults: &[crate::dataset::fault::Fault]) -> String {
    crate::dataset::fault::in_words(faults).join("\n")
}

fn list_problems(problems: &[Problem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}
