//! Errors of a controller or a reference.

use std::borrow::Cow;

use feeler_catalogue::Bound;
use feeler_problem::{Remedy, short};

/// The keys that an error may name.
pub(crate) const APPROACH: &str = "approach";
pub(crate) const REFERENCE: &str = "reference";

/// Why a controller or a reference cannot be built. Keys are those of the machine file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    #[error("{lanes} lanes need {lanes} controllers, not {given}")]
    LaneCount { lanes: usize, given: usize },
    #[error("`{key}` {}, not {value}", bound.words())]
    OutOfRange { key: String, value: f64, bound: Bound },
    #[error("`{key}` is {value}, and must be below {bound} ({why})")]
    TooLarge { key: String, value: f64, bound: f64, why: &'static str },
    /// Variants that run side by side must have the same law.
    #[error("lane {lane} has a different control law from lane 0")]
    LawsDiffer { lane: usize },
    /// Variants that run side by side must be sampled at the same instants.
    #[error("lane {lane} is sampled at different instants from lane 0")]
    TimingDiffers { lane: usize },
    #[error("`{}` waits for a force, and the position law reads a position", APPROACH)]
    ApproachNeedsForce,
    #[error("the drive of the approach moves a mass of {value} kg")]
    ApproachMass { value: f64 },
    #[error("an admittance needs a virtual `{mass}` or a virtual `{damping}` above zero")]
    AdmittanceWithoutMassOrDamping {
        /// The key of the virtual mass.
        mass: &'static str,
        /// That of the virtual damping.
        damping: &'static str,
    },
    #[error("a reference of kind `{kind}` needs at least one point")]
    EmptyReference { kind: &'static str },
    #[error("the times of a reference must increase: point {index} is at {time_s} s, after {previous_s} s")]
    TimesNotIncreasing { index: usize, time_s: f64, previous_s: f64 },
    #[error("a table has {times} times and {values} values")]
    TableLengths { times: usize, values: usize },
    #[error("no line of a multisine of period {period_s} s lies in {low_hz} to {high_hz} Hz")]
    NoLines { period_s: f64, low_hz: f64, high_hz: f64 },
    #[error("a PRBS of order {order} is not available")]
    PrbsOrder { order: u32, min: u32, max: u32 },
}

impl Remedy for ControlError {
    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::LaneCount { lanes, .. } => format!("give {lanes} controllers").into(),
            Self::OutOfRange { key, bound: Bound::Any, .. } => format!("write a finite `{key}`").into(),
            Self::OutOfRange { bound, .. } => format!("this {}", bound.words()).into(),
            Self::TooLarge { key, bound, .. } => format!("choose `{key}` below {}", short(*bound)).into(),
            Self::LawsDiffer { .. } => {
                "give variants that run side by side the same law, with other numbers only".into()
            }
            Self::TimingDiffers { .. } => {
                "give variants that run side by side the same `period`, `offset` and `jitter`".into()
            }
            Self::ApproachNeedsForce => {
                format!("use a force, impedance or admittance law, or leave `{APPROACH}` out").into()
            }
            Self::ApproachMass { .. } => {
                format!("let it drive a body that can move, or leave `{APPROACH}` out").into()
            }
            Self::AdmittanceWithoutMassOrDamping { mass, damping } => {
                format!("write a `{mass}` or a `{damping}` above zero").into()
            }
            Self::EmptyReference { .. } => "give it at least one point".into(),
            Self::TimesNotIncreasing { .. } => "sort the points by time, and write each time once".into(),
            Self::TableLengths { .. } => "give each time one value".into(),
            Self::NoLines { .. } => "lengthen the period or widen the band".into(),
            Self::PrbsOrder { min, max, .. } => format!("choose an order from {min} to {max}").into(),
        }
    }

    fn place(&self) -> String {
        match self {
            Self::OutOfRange { key, .. } | Self::TooLarge { key, .. } => key.clone(),
            Self::ApproachNeedsForce | Self::ApproachMass { .. } => APPROACH.into(),
            Self::AdmittanceWithoutMassOrDamping { mass, .. } => (*mass).into(),
            Self::EmptyReference { .. }
            | Self::TimesNotIncreasing { .. }
            | Self::TableLengths { .. }
            | Self::NoLines { .. }
            | Self::PrbsOrder { .. } => REFERENCE.into(),
            Self::LaneCount { .. } | Self::LawsDiffer { .. } | Self::TimingDiffers { .. } => String::new(),
        }
    }

    fn is_of_caller(&self) -> bool {
        matches!(self, Self::LaneCount { .. } | Self::LawsDiffer { .. } | Self::TimingDiffers { .. })
    }
}

/// `value` if it obeys `bound`.
fn within(key: impl Into<String>, value: f64, bound: Bound) -> Result<f64, ControlError> {
    if bound.admits(value) {
        Ok(value)
    } else {
        Err(ControlError::OutOfRange { key: key.into(), value, bound })
    }
}

/// `value` if it is finite and above zero.
pub(crate) fn positive(key: impl Into<String>, value: f64) -> Result<f64, ControlError> {
    within(key, value, Bound::Positive)
}

/// `value` if it is finite and not below zero.
pub(crate) fn not_negative(key: impl Into<String>, value: f64) -> Result<f64, ControlError> {
    within(key, value, Bound::NotNegative)
}

/// `value` if it is finite.
pub(crate) fn finite(key: impl Into<String>, value: f64) -> Result<f64, ControlError> {
    within(key, value, Bound::Any)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = [
            ControlError::LaneCount { lanes: 4, given: 3 },
            ControlError::OutOfRange { key: "period".into(), value: 0.0, bound: Bound::Positive },
            ControlError::OutOfRange { key: "kd".into(), value: -1.0, bound: Bound::NotNegative },
            ControlError::OutOfRange { key: "kp".into(), value: f64::NAN, bound: Bound::Any },
            ControlError::TooLarge {
                key: "filter".into(),
                value: 900.0,
                bound: 500.0,
                why: "half the sample rate",
            },
            ControlError::LawsDiffer { lane: 1 },
            ControlError::TimingDiffers { lane: 1 },
            ControlError::ApproachNeedsForce,
            ControlError::ApproachMass { value: 0.0 },
            ControlError::AdmittanceWithoutMassOrDamping { mass: "mass", damping: "damping" },
            ControlError::EmptyReference { kind: "steps" },
            ControlError::TimesNotIncreasing { index: 1, time_s: 0.5, previous_s: 1.0 },
            ControlError::TableLengths { times: 2, values: 3 },
            ControlError::NoLines { period_s: 1.0, low_hz: 0.1, high_hz: 0.2 },
            ControlError::PrbsOrder { order: 99, min: 2, max: 24 },
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
