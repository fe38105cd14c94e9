//! Contents and mistakes of a checked file.

use feeler_diagnosis::DiagnosisError;
use feeler_diagnosis::dataset::{Fault, FaultKind};
use feeler_engine::EngineError;
use feeler_files::FormatError;
use feeler_problem::{Problem, Remedy};

/// Readings of one motion that differ by this factor or more certainly have different units.
const CERTAIN_FACTOR: f64 = 100.0;

/// Why a file cannot be used.
pub(super) enum Mistakes {
    Format(FormatError),
    Engine(EngineError),
    Series(DiagnosisError),
}

impl Mistakes {
    pub(super) fn error(&self) -> &dyn Remedy {
        match self {
            Self::Format(error) => error,
            Self::Engine(error) => error,
            Self::Series(error) => error,
        }
    }
}

/// Contents of a file without mistakes.
pub(super) struct Sound {
    pub(super) about: String,
    /// Assumptions of the diagnosis about the records.
    pub(super) warnings: Vec<Fault>,
    /// Doubtful numbers.
    pub(super) doubts: Vec<Problem>,
}

impl Sound {
    /// Whether a column certainly has another unit than its file states.
    pub(super) fn has_wrong_unit(&self) -> bool {
        self.warnings.iter().any(is_wrong_unit)
    }
}

impl From<String> for Sound {
    fn from(about: String) -> Self {
        Self { about, warnings: Vec::new(), doubts: Vec::new() }
    }
}

/// Whether a column certainly has another unit than its file states.
pub(super) fn is_wrong_unit(fault: &Fault) -> bool {
    match fault.kind {
        FaultKind::Units { factor, .. } => factor.abs().max(1.0 / factor.abs()) > CERTAIN_FACTOR,
        _ => false,
    }
}
