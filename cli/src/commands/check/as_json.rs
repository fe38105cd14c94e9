//! The findings of a check, for programs.

use std::path::Path;

use feeler_diagnosis::DiagnosisError;
use feeler_diagnosis::dataset::Fault;
use feeler_files::Located;
use feeler_problem::Problem;
use serde::Serialize;

use super::found::{Mistakes, Sound, is_wrong_unit};

/// A file that was checked. The book shows the comments.
#[derive(Serialize)]
pub(super) struct Checked {
    /// The file as named on the command line.
    file: String,
    /// Whether it has no mistakes.
    ok: bool,
    /// Contents of the file in a few words; absent if the file cannot be used.
    #[serde(skip_serializing_if = "Option::is_none")]
    about: Option<String>,
    /// Mistakes of the file.
    problems: Vec<Finding>,
    /// Doubtful numbers and records that are used with an assumption.
    warnings: Vec<Finding>,
}

/// A mistake or a warning.
#[derive(Default, Serialize)]
struct Finding {
    /// The file with the finding, `--set` for an override; absent if it is the file of this entry.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    /// Line or row, from 1; absent if the finding has no line.
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<usize>,
    /// Column in characters, from 1; absent without a line.
    #[serde(skip_serializing_if = "Option::is_none")]
    column: Option<usize>,
    /// Dotted path of the key; absent if the finding concerns no key.
    #[serde(skip_serializing_if = "Option::is_none")]
    key: Option<String>,
    /// The finding in words.
    message: String,
    /// How to correct it.
    remedy: String,
}

impl Checked {
    pub(super) fn new(path: &Path, result: &Result<Sound, Mistakes>) -> Self {
        let file = path.display().to_string();
        match result {
            Ok(sound) => {
                let (wrong, others): (Vec<&Fault>, Vec<&Fault>) =
                    sound.warnings.iter().partition(|found| is_wrong_unit(found));
                let problems: Vec<Finding> = wrong.into_iter().map(Finding::of_fault).collect();
                let others = others.into_iter().map(Finding::of_fault);
                let warnings = others.chain(sound.doubts.iter().map(Finding::of_problem)).collect();
                Self { file, ok: problems.is_empty(), about: Some(sound.about.clone()), problems, warnings }
            }
            Err(mistakes) => {
                let problems = match mistakes {
                    Mistakes::Format(error) => error.problems.iter().map(Finding::of_located).collect(),
                    Mistakes::Series(DiagnosisError::Data { faults }) => {
                        faults.iter().map(Finding::of_fault).collect()
                    }
                    other => other.error().problems().iter().map(Finding::of_problem).collect(),
                };
                Self { file, ok: false, about: None, problems, warnings: Vec::new() }
            }
        }
    }
}

impl Finding {
    fn of_located(found: &Located) -> Self {
        let at = |number: usize| (number > 0).then_some(number);
        Self {
            file: Some(found.file.clone()),
            line: at(found.line),
            column: at(found.column),
            key: (!found.key.is_empty()).then(|| found.key.clone()),
            message: found.message.clone(),
            remedy: found.remedy.clone(),
        }
    }

    fn of_fault(fault: &Fault) -> Self {
        let problem = fault.problem();
        Self {
            file: Some(fault.file.clone()),
            line: fault.row,
            key: fault.column.clone(),
            message: problem.message,
            remedy: problem.remedy,
            ..Self::default()
        }
    }

    fn of_problem(found: &Problem) -> Self {
        Self {
            key: (!found.key.is_empty()).then(|| found.key.clone()),
            message: found.message.clone(),
            remedy: found.remedy.clone(),
            ..Self::default()
        }
    }
}
