//! What went wrong, as a person reads it, and the exit code for programs.

use std::fmt;
use std::io;
use std::path::Path;
use std::process::ExitCode;

use feeler_diagnosis::DiagnosisError;
use feeler_files::FormatError;
use feeler_studies::Refusal;
use feeler_studies::run::RunError;
use feeler_studies::sweep::SweepError;

use super::stderr;

/// All went well.
pub(crate) const DONE: u8 = 0;
/// A check failed.
pub(crate) const CHECK_FAILED: u8 = 1;
/// The input is wrong, or the output cannot go where it should.
pub(crate) const BAD_INPUT: u8 = 2;
/// A mistake of the program.
pub(crate) const INTERNAL: u8 = 3;

/// Bad input, with what to do about it.
#[derive(Debug)]
pub(crate) struct BadInput {
    message: String,
    remedy: String,
}

impl BadInput {
    pub(crate) fn error(message: impl Into<String>, remedy: impl Into<String>) -> anyhow::Error {
        Self { message: message.into(), remedy: remedy.into() }.into()
    }

    /// A request that a library refuses.
    pub(crate) fn from_refusal(refusal: Refusal) -> anyhow::Error {
        Self::error(refusal.message, refusal.remedy)
    }

    /// A file or folder that cannot be written.
    pub(crate) fn unwritable(path: &Path, source: &std::io::Error) -> anyhow::Error {
        let file = path
            .ancestors()
            .find(|part| part.is_file())
            .filter(|file| *file != path || source.kind() == io::ErrorKind::AlreadyExists);
        if let Some(file) = file {
            let message =
                format!("cannot write {}: {} is a file, not a folder", path.display(), file.display());
            return Self::error(message, "name another folder with --out");
        }
        if matches!(source.kind(), io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded) {
            let message = format!("cannot write {}: {source}", path.display());
            return Self::error(
                message,
                "make room there, or name another place with --out; a sweep goes on where it was",
            );
        }
        Self::error(
            format!("cannot write {}: {source}", path.display()),
            "name another place with --out, or make this one writable",
        )
    }
}

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}\n  help: {}", self.message, self.remedy)
    }
}

impl std::error::Error for BadInput {}

/// What has been said already; all that is left is the exit code.
#[derive(Debug)]
pub(crate) struct Reported;

impl fmt::Display for Reported {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("mistakes were reported")
    }
}

impl std::error::Error for Reported {}

/// A check has failed, and the table says which.
#[derive(Debug)]
pub(crate) struct CheckFailed;

impl fmt::Display for CheckFailed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a check failed")
    }
}

impl std::error::Error for CheckFailed {}

/// Prints an error and gives its exit code.
pub(crate) fn report(error: &anyhow::Error) -> ExitCode {
    if stderr::is_broken_pipe(error) {
        return ExitCode::from(DONE);
    }
    let (text, code) = if error.is::<Reported>() {
        return ExitCode::from(BAD_INPUT);
    } else if error.is::<CheckFailed>() {
        return ExitCode::from(CHECK_FAILED);
    } else if let Some(bad) = error.downcast_ref::<BadInput>() {
        (bad.to_string(), BAD_INPUT)
    } else if let Some(mistakes) = error.downcast_ref::<FormatError>() {
        (mistakes.report(stderr::has_colours()), BAD_INPUT)
    } else if let Some(sweep) = error.downcast_ref::<SweepError>() {
        of_sweep(sweep)
    } else if let Some(diagnosis) = error.downcast_ref::<DiagnosisError>() {
        of_diagnosis(diagnosis)
    } else {
        match error.downcast_ref::<RunError>() {
            Some(RunError::Engine(engine)) => {
                (format!("error: this scenario cannot be run\n{engine}"), BAD_INPUT)
            }
            Some(RunError::Write { path, source }) => {
                (BadInput::unwritable(path, source).to_string(), BAD_INPUT)
            }
            _ => (
                format!(
                    "error: {error:#}\n  help: this is a mistake of feeler itself; please report it with the file"
                ),
                INTERNAL,
            ),
        }
    };
    stderr::complain(&text);
    ExitCode::from(code)
}

fn of_sweep(error: &SweepError) -> (String, u8) {
    let with = |remedy: &str| {
        (BadInput { message: error.to_string(), remedy: remedy.into() }.to_string(), BAD_INPUT)
    };
    match error {
        SweepError::Format(mistakes) => (mistakes.report(stderr::has_colours()), BAD_INPUT),
        SweepError::Io { path, source } => (BadInput::unwritable(path, source).to_string(), BAD_INPUT),
        SweepError::OtherSweep { .. } => with("name another folder with --out, or remove this one"),
        SweepError::NoSweep { .. } => with("name the folder that `feeler sweep --out` was given"),
        SweepError::Incomplete { .. } => {
            with("run the shards that have not ended, or name their folders too")
        }
        SweepError::RefineShard => with("run it on one machine, or remove [refine]"),
        SweepError::Parquet { .. } | SweepError::Column { .. } => {
            with("remove the file; what is missing is run again")
        }
        _ => (format!("error: {error}"), INTERNAL),
    }
}

fn of_diagnosis(error: &DiagnosisError) -> (String, u8) {
    let with = |remedy: &str| {
        (BadInput { message: error.to_string(), remedy: remedy.into() }.to_string(), BAD_INPUT)
    };
    match error {
        DiagnosisError::Format(mistakes) => (mistakes.report(stderr::has_colours()), BAD_INPUT),
        DiagnosisError::Read { .. } => {
            with("check the file's name in dataset.toml, and that it is a table with a header row")
        }
        // Each fault says its own remedy.
        DiagnosisError::Data { .. } => (format!("error: these records cannot be used\n{error}"), BAD_INPUT),
        DiagnosisError::Unreadable { remedy, .. } => with(remedy),
        DiagnosisError::Signal { .. } => {
            with("replay a machine with the elements that the dataset names, or change [columns]")
        }
        DiagnosisError::Machine { .. } => with("`feeler check` on the machine file says more"),
        _ => (format!("error: {error}"), INTERNAL),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_full_disk_has_a_remedy() {
        let full = io::Error::from(io::ErrorKind::StorageFull);
        let text = BadInput::unwritable(Path::new("out/sweep.parquet"), &full).to_string();
        assert!(
            text.contains("cannot write out/sweep.parquet") && text.contains("make room there"),
            "{text}"
        );
    }
}
