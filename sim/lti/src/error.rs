//! Errors of this crate.

use std::borrow::Cow;

use feeler_problem::Remedy;

/// The error of every fallible function of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LtiError {
    #[error("{matrix} is {found_rows} x {found_columns}, but {expected_rows} x {expected_columns} is needed")]
    Shape {
        matrix: &'static str,
        expected_rows: usize,
        expected_columns: usize,
        found_rows: usize,
        found_columns: usize,
    },
    #[error("{quantity} is not finite")]
    NotFinite { quantity: &'static str },
    #[error("{quantity} is {value}, which is outside {range}")]
    OutOfRange {
        /// Name of the number, with its unit.
        quantity: &'static str,
        value: f64,
        range: &'static str,
    },
    #[error("{kind} {index} does not exist: there are {count}")]
    NoSuchChannel {
        /// "input" or "output".
        kind: &'static str,
        /// The index asked for, from zero.
        index: usize,
        count: usize,
    },
    #[error("sample times {left_s} s and {right_s} s differ")]
    SampleTimes { left_s: f64, right_s: f64 },
    /// A feedback connection has no unique solution: I + D1 D2 is singular.
    #[error("the algebraic loop of the feedback connection has no unique solution")]
    AlgebraicLoop,
    #[error("the response at {re} + {im}j is infinite: a pole lies there")]
    AtPole {
        /// Real part of the point (s or z).
        re: f64,
        /// Imaginary part of the point (s or z).
        im: f64,
    },
    #[error("the eigenvalues of a matrix of order {order} did not converge")]
    EigenvaluesNotConverged { order: usize },
    #[error("the transfer function has deficient rank at every frequency, so its zeros are not isolated")]
    Degenerate,
    #[error("{needed} samples are needed, but the record has {found}")]
    RecordTooShort { needed: usize, found: usize },
    #[error("the records have {left} and {right} samples, which must be equal")]
    RecordLengths { left: usize, right: usize },
    #[error("the input has no power at {frequency_hz} Hz")]
    NotExcited { frequency_hz: f64 },
}

impl Remedy for LtiError {
    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Shape { matrix, expected_rows, expected_columns, .. } => {
                format!("give `{matrix}` {expected_rows} rows and {expected_columns} columns").into()
            }
            Self::NotFinite { quantity } => {
                format!("look for extreme or missing numbers in the values that give `{quantity}`").into()
            }
            Self::OutOfRange { quantity, range, .. } => format!("choose {quantity} within {range}").into(),
            Self::NoSuchChannel { kind, count: 0, .. } => format!("add an {kind}").into(),
            Self::NoSuchChannel { kind, count, .. } => {
                format!("name an {kind} from 0 to {}", count - 1).into()
            }
            Self::SampleTimes { .. } => "bring both systems to one sample time".into(),
            Self::AlgebraicLoop => {
                "delay one of the two systems by a sample, or change its direct gain".into()
            }
            Self::AtPole { .. } => "ask for the response at another frequency, or add damping".into(),
            Self::EigenvaluesNotConverged { .. } => {
                "bring masses, stiffnesses and dampings closer together in size".into()
            }
            Self::Degenerate => "choose an input that moves the output".into(),
            Self::RecordTooShort { needed, .. } => format!("record {needed} samples or more").into(),
            Self::RecordLengths { .. } => "cut both records to one length".into(),
            Self::NotExcited { frequency_hz } => {
                format!("excite at {frequency_hz} Hz, or leave this frequency out").into()
            }
        }
    }

    fn is_of_caller(&self) -> bool {
        matches!(
            self,
            Self::Shape { .. }
                | Self::NoSuchChannel { .. }
                | Self::SampleTimes { .. }
                | Self::RecordLengths { .. }
        )
    }
}

/// Fails with [`LtiError::NotFinite`] if a value is not finite.
pub(crate) fn require_finite<'a>(
    quantity: &'static str,
    values: impl IntoIterator<Item = &'a f64>,
) -> Result<(), LtiError> {
    if values.into_iter().all(|v| v.is_finite()) { Ok(()) } else { Err(LtiError::NotFinite { quantity }) }
}

/// Fails with [`LtiError::OutOfRange`] unless the value is finite and positive.
pub(crate) fn require_positive(quantity: &'static str, value: f64) -> Result<(), LtiError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(LtiError::OutOfRange { quantity, value, range: "(0, inf)" })
    }
}

/// Fails with [`LtiError::OutOfRange`] unless the value is finite and not negative.
pub(crate) fn require_not_negative(quantity: &'static str, value: f64) -> Result<(), LtiError> {
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        Err(LtiError::OutOfRange { quantity, value, range: "[0, inf)" })
    }
}

/// Fails with [`LtiError::Shape`] unless the matrix has the stated shape.
pub(crate) fn require_shape<T>(
    matrix: &'static str,
    found: &nalgebra::DMatrix<T>,
    (expected_rows, expected_columns): (usize, usize),
) -> Result<(), LtiError> {
    let (found_rows, found_columns) = (found.nrows(), found.ncols());
    if (found_rows, found_columns) == (expected_rows, expected_columns) {
        Ok(())
    } else {
        Err(LtiError::Shape { matrix, expected_rows, expected_columns, found_rows, found_columns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = [
            LtiError::Shape {
                matrix: "A",
                expected_rows: 2,
                expected_columns: 2,
                found_rows: 2,
                found_columns: 3,
            },
            LtiError::NotFinite { quantity: "A" },
            LtiError::OutOfRange { quantity: "period (s)", value: -1.0, range: "(0, inf)" },
            LtiError::NoSuchChannel { kind: "output", index: 2, count: 2 },
            LtiError::NoSuchChannel { kind: "input", index: 0, count: 0 },
            LtiError::SampleTimes { left_s: 1e-3, right_s: 2e-3 },
            LtiError::AlgebraicLoop,
            LtiError::AtPole { re: 0.0, im: 1.0 },
            LtiError::EigenvaluesNotConverged { order: 8 },
            LtiError::Degenerate,
            LtiError::RecordTooShort { needed: 16, found: 3 },
            LtiError::RecordLengths { left: 3, right: 4 },
            LtiError::NotExcited { frequency_hz: 5.0 },
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
