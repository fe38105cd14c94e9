//! How far fitted values may be off beyond what their residuals say.
//!
//! A fit knows its parameters as well as its model is right. For most laws that is so, and the intervals of
//! the fit hold (on blind cases of `docs/diagnosis.md` 9 of 10 values were within them). Dry friction is
//! another matter: what real friction does before it slides, and how it falls with speed, no law of the
//! library has, so that its levels, and whatever is fitted beside it, are shifted by more than residuals
//! show. By how much was measured on the same cases, and is added.

use feeler_plant::effects::Trait;

use crate::fit::candidates::Candidate;
use crate::kinds::dossier;

/// By what the deviations of values beside dry friction are larger than their fit says: of 8 delays and modes
/// the middle one was off by 4.
const BESIDE_FRICTION: f64 = 4.0;

/// One deviation of a value of cause `i`, the parameter in this position, of which the fit says `deviation`,
/// on rows `spacing_s` apart.
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
    match (known.read_off, (known.fractions_off)()) {
        (Some(spread), _) => deviation.min(spread * value.abs()),
        (None, Some(fractions)) => deviation.hypot(fractions[parameter] * value),
        _ if causes.iter().any(|cause| cause.definition.has(Trait::DryFriction)) => {
            BESIDE_FRICTION * deviation
        }
        _ => deviation,
    }
}
