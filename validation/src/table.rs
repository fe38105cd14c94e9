//! Checked rows: claim, expectation, result.

use serde::Serialize;

/// The criterion of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RowKind {
    /// The value is close to the expectation.
    Close,
    /// The value is at most the tolerance.
    AtMost,
    /// The value is above the expectation.
    Above,
    /// The value is 1: the claim is true.
    Holds,
}

/// One check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckRow {
    /// Name of the checked quantity.
    pub name: String,
    /// Source of the expectation: a closed form, independent numbers, or a claim of the paper.
    pub claim: String,
    /// The criterion that the value must meet.
    pub kind: RowKind,
    /// The expected value; NaN if there is only a bound.
    pub expected: f64,
    /// The value that was found.
    pub got: f64,
    /// Largest difference allowed.
    pub tolerance: f64,
    /// Whether the check passed.
    pub pass: bool,
}

impl CheckRow {
    /// Both values within an absolute tolerance, or both infinite.
    pub fn close(
        name: impl Into<String>,
        claim: impl Into<String>,
        got: f64,
        expected: f64,
        tolerance: f64,
    ) -> Self {
        let pass = (got - expected).abs() <= tolerance
            || (got.is_infinite() && expected.is_infinite() && got.signum() * expected.signum() > 0.0);
        Self { name: name.into(), claim: claim.into(), kind: RowKind::Close, expected, got, tolerance, pass }
    }

    /// Both values within a relative tolerance.
    pub fn relative(
        name: impl Into<String>,
        claim: impl Into<String>,
        got: f64,
        expected: f64,
        tolerance: f64,
    ) -> Self {
        Self::close(
            name,
            claim,
            got,
            expected,
            if expected.is_finite() { tolerance * expected.abs() } else { tolerance },
        )
    }

    /// A magnitude that must not exceed a bound.
    pub(crate) fn at_most(name: impl Into<String>, claim: impl Into<String>, got: f64, bound: f64) -> Self {
        Self {
            name: name.into(),
            claim: claim.into(),
            kind: RowKind::AtMost,
            expected: 0.0,
            got,
            tolerance: bound,
            pass: got <= bound,
        }
    }

    /// A value that must exceed a bound.
    pub fn above(name: impl Into<String>, claim: impl Into<String>, got: f64, bound: f64) -> Self {
        Self {
            name: name.into(),
            claim: claim.into(),
            kind: RowKind::Above,
            expected: bound,
            got,
            tolerance: f64::INFINITY,
            pass: got > bound,
        }
    }

    /// A statement that must hold.
    pub fn holds(name: impl Into<String>, claim: impl Into<String>, holds: bool) -> Self {
        Self {
            name: name.into(),
            claim: claim.into(),
            kind: RowKind::Holds,
            expected: 1.0,
            got: f64::from(u8::from(holds)),
            tolerance: 0.0,
            pass: holds,
        }
    }
}

/// All rows.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CheckTable {
    /// The rows, in the order in which they were checked.
    pub rows: Vec<CheckRow>,
}

impl CheckTable {
    /// Whether every row passed.
    pub fn passed(&self) -> bool {
        self.rows.iter().all(|row| row.pass)
    }

    /// The rows that did not pass.
    pub fn failures(&self) -> impl Iterator<Item = &CheckRow> {
        self.rows.iter().filter(|row| !row.pass)
    }
}
