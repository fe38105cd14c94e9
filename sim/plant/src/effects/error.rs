//! Why an effect cannot be applied.

use std::borrow::Cow;

use feeler_problem::Remedy;
use thiserror::Error;

use super::{HostKind, Kind};

/// Why an effect cannot be applied to its element.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the message of an error says what its fields are")]
pub enum EffectError {
    /// The element has the wrong kind for the effect.
    #[error("`{kind}` does not sit under {}; it goes under {}", .found.phrase(), either(.expected))]
    WrongHost {
        kind: Kind,
        /// The element under which it stands.
        found: HostKind,
        /// Elements that take it.
        expected: &'static [HostKind],
    },
    /// The element has the right kind, but is in the wrong place.
    #[error("`{kind}` needs {needs}")]
    WrongSite {
        kind: Kind,
        /// Requirement on the element.
        needs: &'static str,
    },
    /// Parameters are missing, or there are too many.
    #[error("`{kind}` has {expected} parameters, not {given}")]
    Count {
        kind: Kind,
        /// Number of parameters of the kind.
        expected: usize,
        /// Number that was given.
        given: usize,
    },
    /// A value outside the bounds of the parameter.
    #[error("`{parameter}` = {value} is not between {low} and {high}")]
    OutOfBounds {
        parameter: &'static str,
        value: f64,
        /// Smallest value.
        low: f64,
        /// Largest value.
        high: f64,
    },
    /// A split would leave no mass on one side.
    #[error("`{parameter}` = {value_kg} kg takes all of the {available_kg} kg available")]
    MassExceeded {
        parameter: &'static str,
        value_kg: f64,
        /// Mass that is available.
        available_kg: f64,
    },
    /// A value is out of range on this host.
    #[error("`{parameter}` = {value}: {reason}")]
    Value {
        parameter: &'static str,
        value: f64,
        /// Why not.
        reason: &'static str,
        remedy: &'static str,
    },
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
