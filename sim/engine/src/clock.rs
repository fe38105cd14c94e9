//! Instants at which something discrete happens.

/// Instants closer than this are one, s: far below any event tolerance, far above the rounding of sums of periods and delays.
pub(crate) const SAME_INSTANT_S: f64 = 1e-12;

/// Whether an instant is due at `t_s`.
pub(crate) fn due(instant_s: f64, t_s: f64) -> bool {
    instant_s <= t_s + SAME_INSTANT_S
}
