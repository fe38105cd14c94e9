//! How far a believed value may be off where its file states nothing, as a fraction.

/// Masses, stiffnesses and gains.
pub(crate) const FRACTION: f64 = 0.10;
/// Dampings: a factor of one and this.
pub(crate) const DAMPING: f64 = 1.0;
/// Gaps of contacts.
pub(crate) const GAP: f64 = 0.05;
