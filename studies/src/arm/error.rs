//! What can be wrong with the axis of an arm.

use feeler_analysis::AnalysisError;
use feeler_arm::ArmError;
use thiserror::Error;

use feeler_files::FormatError;

/// Why an arm has no axis.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ArmFileError {
    /// The arm or its pose.
    #[error(transparent)]
    Arm(#[from] ArmError),
    /// The arm file.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The machine that it gives has numbers that no machine file takes.
    #[error(
        "the axis of this arm on this contact cannot be simulated: {why}; check `stiffness`, `damping`, `friction` and `rotor_inertia` of [joints], --contact-stiffness and --contact-damping for extreme numbers"
    )]
    Extreme {
        /// What is wrong with its numbers.
        why: String,
    },
    /// Its linear theory.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
}
