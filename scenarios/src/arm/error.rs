//! What can be wrong with the axis of an arm.

use feeler_analysis::AnalysisError;
use feeler_arm::ArmError;
use thiserror::Error;

use crate::format::FormatError;

/// Why an arm has no axis.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ArmFileError {
    /// The arm or its pose.
    #[error(transparent)]
    Arm(#[from] ArmError),
    /// The machine that it gives.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Its linear theory.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
}
