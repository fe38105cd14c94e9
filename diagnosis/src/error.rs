//! Errors that stop a diagnosis.

use std::borrow::Cow;
use std::path::PathBuf;

use feeler_files::FormatError;
use feeler_logs::LogError;
use feeler_lti::LtiError;
use feeler_problem::{Problem, Remedy, in_lines};
use thiserror::Error;

use crate::dataset::fault::Fault;

/// The reason why a diagnosis is impossible.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DiagnosisError {
    /// The dataset file, or the machine file that it names, has mistakes.
    #[error(transparent)]
    Format(#[from] FormatError),
    #[error(transparent)]
    Log(LogError),
    #[error("{}: {reason}", .file.display())]
    Unreadable { file: PathBuf, reason: String, remedy: &'static str },
    /// `known` lists the joints that have both; it is empty if the only such joint has no name.
    #[error("no joint `{joint}` has both a target and a position; {} has", one_of(.known))]
    NoJoint { joint: String, known: String },
    #[error("{}", .problem.message)]
    Unwritable { problem: Problem },
    /// A fault of the measured series that no assumption can repair.
    #[error("{}", list_faults(.faults))]
    Data { faults: Vec<Fault> },
    /// A column names a signal that the replayed machine does not have.
    #[error("column `{column}` is `{signal}`, which this machine lacks: {reason}")]
    Signal { column: String, signal: String, reason: String, remedy: String },
    #[error(
        "a diagnosis fits some experiments and checks on others: here {fitted} are to be fitted and \
         {checked} to be checked on"
    )]
    Roles { fitted: usize, checked: usize },
    #[error(
        "the believed machine predicts no finite motion over these records, whose rows are {spacing_s} s \
         apart"
    )]
    Unbounded { spacing_s: f64 },
    #[error("the time ran out")]
    Late,
    #[error("the machine cannot be moved: {}", in_lines(.problems))]
    Machine { problems: Vec<Problem> },
    #[error("the equations of motion have no usable exponential: {0}")]
    Exponential(#[from] LtiError),
}

fn list_faults(faults: &[Fault]) -> String {
    crate::dataset::fault::in_words(faults).join("\n")
}

impl Remedy for DiagnosisError {
    fn passed_on(&self) -> Option<&dyn Remedy> {
        match self {
            Self::Format(error) => Some(error),
            Self::Log(error) => Some(error),
            Self::Exponential(error) => Some(error),
            _ => None,
        }
    }

    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Format(error) => error.remedy(),
            Self::Exponential(error) => error.remedy(),
            Self::Log(error) => error.remedy(),
            Self::Unreadable { remedy, .. } => (*remedy).into(),
            Self::NoJoint { known, .. } if known.is_empty() => "leave out --joint".into(),
            Self::NoJoint { known, .. } => format!("name one of {known} with --joint").into(),
            Self::Unwritable { problem } => problem.remedy.as_str().into(),
            Self::Data { faults } => faults.first().map_or_else(String::new, Fault::remedy).into(),
            Self::Signal { remedy, .. } => format!(
                "replay a machine with the elements that the dataset names, or change [columns]: {remedy}"
            )
            .into(),
            Self::Roles { .. } => {
                "record one more, or give the experiments `role = \"fit\"` and `role = \"check\"`".into()
            }
            Self::Unbounded { .. } => "bring the time to seconds, and commands to N, or m/s".into(),
            Self::Late => "give a longer `--budget`".into(),
            Self::Machine { problems } => problems.first().map_or_else(
                || "check the machine file by itself".into(),
                |problem| problem.remedy.as_str().into(),
            ),
        }
    }

    fn place(&self) -> String {
        match self {
            Self::Data { faults } => faults.first().map_or_else(String::new, Fault::place),
            Self::Machine { problems } => problems.first().map_or_else(String::new, |p| p.key.clone()),
            Self::Signal { column, .. } => format!("columns.{column}"),
            Self::NoJoint { .. }
            | Self::Unwritable { .. }
            | Self::Unreadable { .. }
            | Self::Roles { .. }
            | Self::Unbounded { .. }
            | Self::Late => String::new(),
            Self::Format(_) | Self::Log(_) | Self::Exponential(_) => {
                self.passed_on().map_or_else(String::new, Remedy::place)
            }
        }
    }

    fn problems(&self) -> Vec<Problem> {
        match self {
            Self::Format(error) => error.problems(),
            Self::Log(error) => error.problems(),
            Self::Data { faults } => crate::dataset::fault::problems(faults),
            Self::Machine { problems } if !problems.is_empty() => problems.clone(),
            _ => vec![Problem::new(self.place(), self.to_string(), self.remedy())],
        }
    }
}

fn one_of(known: &str) -> String {
    if known.is_empty() { "the only one, without a name,".into() } else { format!("each of {known}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::FaultKind;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let wrong = feeler_files::Document::parse("mass = = 3", "a.toml").map(drop);
        let file = || PathBuf::from("a.csv");
        let missing = feeler_logs::read_file(std::path::Path::new("no such file"), None).err();
        let all: Vec<DiagnosisError> = (wrong.err().map(DiagnosisError::Format).into_iter())
            .chain(missing.map(DiagnosisError::Log))
            .chain([
                DiagnosisError::Unreadable {
                    file: file(),
                    reason: "it is empty".into(),
                    remedy: "record it again",
                },
                DiagnosisError::Data {
                    faults: vec![Fault {
                        file: "a.csv".into(),
                        column: None,
                        row: Some(3),
                        kind: FaultKind::TimeGoesBack,
                    }],
                },
                DiagnosisError::Signal {
                    column: "force_n".into(),
                    signal: "gauge.reading".into(),
                    reason: "there is no `gauge`".into(),
                    remedy: "did you mean `force`?".into(),
                },
                DiagnosisError::NoJoint { joint: "hip".into(), known: "elbow, wrist".into() },
                DiagnosisError::NoJoint { joint: "hip".into(), known: String::new() },
                DiagnosisError::Unwritable {
                    problem: Problem::new("", "cannot write out", "name another place with --out"),
                },
                DiagnosisError::Roles { fitted: 1, checked: 0 },
                DiagnosisError::Unbounded { spacing_s: 1e-3 },
                DiagnosisError::Late,
                DiagnosisError::Machine {
                    problems: vec![Problem::new("bodies", "nothing can move", "free a body")],
                },
                DiagnosisError::Machine { problems: Vec::new() },
                DiagnosisError::Exponential(LtiError::NotFinite { quantity: "A" }),
            ])
            .collect();
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
