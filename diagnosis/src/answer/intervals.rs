//! Intervals of fitted values, and their uncertainty beyond that from residuals.
//!
//! The uncertainty from a fit is as valid as the model. For most laws it holds: in blind cases of
//! `docs/diagnosis.md`, 9 of 10 values were within their intervals. Dry friction is different. No law of the
//! library describes real presliding friction, or exactly how friction falls with speed. The levels of
//! friction, and other values fitted with them, have larger errors than the residuals show. These errors were
//! measured on the same cases, and are added here.

use feeler_plant::effects::{ABOVE_ZERO, Parameter, Scale, Trait};

use crate::fit::candidates::Candidate;
use crate::kinds::dossier;

/// Factor on the deviations of values fitted together with dry friction: for 8 delays and modes the median
/// error was 4 times the fit's deviation.
pub(super) const BESIDE_FRICTION: f64 = 4.0;

/// Standard deviation of a positive value as a share of it: predictions soften contacts and average over
/// rows. Without it lags and stiffnesses of the ordinary bench were off by up to four of their deviations.
const PREDICTED: f64 = 5e-4;

/// Standard deviation of a parameter of cause `i`, widened from the fit's `deviation`; the rows are
/// `spacing_s` apart.
pub(super) fn widened(
    causes: &[Candidate],
    i: usize,
    parameter: usize,
    value: f64,
    deviation: f64,
    spacing_s: f64,
) -> f64 {
    let known = dossier(causes[i].definition.kind);
    let deviation = deviation.hypot(known.off_rows * spacing_s);
    // A value that was not fitted has no deviation.
    let is_share = deviation > 0.0 && causes[i].definition.parameters[parameter].scale == Scale::Log;
    let predicted = if is_share { PREDICTED * value } else { 0.0 };
    let widened = match (known.read_off, (known.fractions_off)()) {
        (Some(spread), _) => deviation.min(spread * value.abs()),
        (None, Some(fractions)) => deviation.hypot(fractions[parameter] * value),
        _ if causes.iter().any(|cause| cause.definition.has(Trait::DryFriction)) => {
            BESIDE_FRICTION * deviation
        }
        _ => deviation,
    };
    widened.hypot(predicted)
}

/// An interval about a value, within the range of its parameter.
pub(super) fn within(parameter: &Parameter, value: f64, half: f64) -> [f64; 2] {
    let (low, high) = parameter.bounds;
    // Zero, not the smallest number, ends the interval of a value that must be positive.
    let low = if low <= ABOVE_ZERO { low.min(0.0) } else { low };
    [(value - half).max(low.min(value)), (value + half).min(high.max(value))]
}
