//! Tolerance of believed values for which a file states none, as a fraction.

/// Masses, stiffnesses and gains.
pub(crate) const FRACTION: f64 = 0.10;
/// Dampings: a factor of one and this.
pub(crate) const DAMPING: f64 = 1.0;
/// Gaps of contacts.
pub(crate) const GAP: f64 = 0.05;
