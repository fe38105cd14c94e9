//! How far fitted values may be off beyond what their residuals say.
//!
//! A fit knows its parameters as well as its model is right. For most laws that is so, and the intervals of
//! the fit hold (on blind cases of `docs/diagnosis.md` 9 of 10 values were within them). Dry friction is
//! another matter: what real friction does before it slides, and how it falls with speed, no law of the
//! library has, so that its levels, and whatever is fitted beside it, are shifted by more than residuals
//! show. By how much was measured on the same cases, and is added.

use crate::fit::candidates::Candidate;
use crate::fit::model::{DRY, STEP_SPREAD};

/// By what the deviations of values beside dry friction are larger than their fit says: of 8 delays and modes
/// the middle one was off by 4.
const BESIDE_FRICTION: f64 = 4.0;
/// One deviation of a friction's level, as a fraction: of 17 the root mean square error was 4.7 %.
const LEVEL: f64 = 0.045;
/// The same of the level that friction falls to with speed, and of that speed: it hides behind viscous
/// damping.
const FALLEN: f64 = 0.18;
const FALL_SPEED: f64 = 0.06;
/// The same of friction that grows with a load.
const LOAD: f64 = 0.06;

/// One deviation of a delay, in rows: a command that is logged in one row may have come at any instant since
/// the last, and samples jitter.
const DELAY_ROWS: f64 = 0.05;

/// One deviation of a value of cause `i`, of which the fit says `deviation`, on rows `spacing_s` apart.
pub(crate) fn widened(
    causes: &[Candidate],
    i: usize,
    parameter: &str,
    value: f64,
    deviation: f64,
    spacing_s: f64,
) -> f64 {
    let kind = causes[i].definition.kind;
    let deviation = if parameter == "delay" { deviation.hypot(DELAY_ROWS * spacing_s) } else { deviation };
    let share = match (kind, parameter) {
        // A step is read off the values, and bounded by that.
        ("encoder-resolution" | "force-resolution", _) => return deviation.min(STEP_SPREAD * value.abs()),
        ("stribeck-friction", "coulomb") => FALLEN,
        ("stribeck-friction", "velocity") => FALL_SPEED,
        ("load-friction", _) => LOAD,
        (kind, _) if DRY.contains(&kind) => LEVEL,
        _ if causes.iter().any(|cause| DRY.contains(&cause.definition.kind)) => {
            return BESIDE_FRICTION * deviation;
        }
        _ => 0.0,
    };
    deviation.hypot(share * value)
}
