//! Default tolerances of believed values, as fractions.

/// For masses, stiffnesses and gains.
pub(crate) const FRACTION: f64 = 0.10;
/// For dampings: a factor of up to one plus this value.
pub(crate) const DAMPING: f64 = 1.0;
/// For the presliding of guides, which changes with place and history: a factor of up to one plus this value.
pub(crate) const PRESLIDING: f64 = 10.0;
/// For gaps of contacts.
pub(crate) const GAP: f64 = 0.05;
