//! Why an effect cannot be applied.

use std::borrow::Cow;

use feeler_problem::Remedy;
use thiserror::Error;

use super::{HostKind, Kind};

/// Why an effect cannot be applied to its element.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum EffectError {
    #[error("`{kind}` does not sit under {}; it goes under {}", .found.phrase(), either(.expected))]
    WrongHost { kind: Kind, found: HostKind, expected: &'static [HostKind] },
    #[error("`{kind}` needs {needs}")]
    WrongSite { kind: Kind, needs: &'static str },
    #[error("`{kind}` has {expected} parameters, not {given}")]
    Count { kind: Kind, expected: usize, given: usize },
    #[error("`{parameter}` = {value} is not between {low} and {high}")]
    OutOfBounds { parameter: &'static str, value: f64, low: f64, high: f64 },
    #[error("`{parameter}` = {value_kg} kg takes all of the {available_kg} kg available")]
    MassExceeded { parameter: &'static str, value_kg: f64, available_kg: f64 },
    #[error("`{parameter}` = {value}: {reason}")]
    Value { parameter: &'static str, value: f64, reason: &'static str, remedy: &'static str },
}

impl Remedy for EffectError {
    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::WrongHost { expected, .. } => format!("move it under {}", either(expected)).into(),
            Self::WrongSite { needs, .. } => format!("move it to {needs}, or leave it out").into(),
            Self::Count { expected, .. } => format!("give {expected} parameters").into(),
            Self::OutOfBounds { low, high, .. } => format!("choose a value from {low} to {high}").into(),
            Self::MassExceeded { available_kg, .. } => format!("choose less than {available_kg} kg").into(),
            Self::Value { remedy, .. } => (*remedy).into(),
        }
    }
}

fn either(kinds: &[HostKind]) -> String {
    kinds.iter().map(|kind| kind.phrase()).collect::<Vec<_>>().join(" or ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = [
            EffectError::WrongHost {
                kind: Kind::Backlash,
                found: HostKind::Body,
                expected: &[HostKind::RigidSpring, HostKind::Contact],
            },
            EffectError::WrongSite { kind: Kind::Backlash, needs: "a joint between two bodies" },
            EffectError::Count { kind: Kind::Backlash, expected: 3, given: 1 },
            EffectError::OutOfBounds { parameter: "width", value: -1.0, low: 0.0, high: 1.0 },
            EffectError::MassExceeded { parameter: "mass", value_kg: 3.0, available_kg: 2.0 },
            EffectError::Value {
                parameter: "width",
                value: 0.0,
                reason: "there is no play",
                remedy: "leave it out",
            },
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
