//! Errors of the axis of an arm.

use std::borrow::Cow;

use feeler_analysis::AnalysisError;
use feeler_arm::ArmError;
use feeler_problem::Remedy;
use thiserror::Error;

use feeler_files::FormatError;

/// Why an arm has no axis.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ArmFileError {
    #[error(transparent)]
    Arm(#[from] ArmError),
    #[error(transparent)]
    Format(#[from] FormatError),
    #[error("the axis of this arm on this contact cannot be simulated: {why}")]
    Extreme { why: String },
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
}

impl Remedy for ArmFileError {
    fn passed_on(&self) -> Option<&dyn Remedy> {
        match self {
            Self::Arm(error) => Some(error),
            Self::Format(error) => Some(error),
            Self::Analysis(error) => Some(error),
            Self::Extreme { .. } => None,
        }
    }

    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Arm(error) => error.remedy(),
            Self::Format(error) => error.remedy(),
            Self::Analysis(error) => error.remedy(),
            Self::Extreme { .. } => {
                "check `stiffness`, `damping`, `viscous_friction`, `dry_friction` and `rotor_inertia` of \
                 [joints], --contact-stiffness and --contact-damping for extreme numbers"
                    .into()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let wrong = feeler_files::Document::parse("mass = = 3", "a.toml").map(drop);
        let all: Vec<ArmFileError> = (wrong.err().map(ArmFileError::Format).into_iter())
            .chain([
                ArmFileError::Arm(ArmError::Normal { normal: [0.0; 3] }),
                ArmFileError::Analysis(AnalysisError::RunEnded { t_s: 0.1 }),
                ArmFileError::Extreme { why: "the mass is infinite".into() },
            ])
            .collect();
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
