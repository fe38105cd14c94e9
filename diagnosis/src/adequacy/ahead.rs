//! Prediction errors at each horizon.

use super::criteria::Criteria;
use super::horizons::{Horizon, WINDOWS_S, worsened};
use crate::fit::least_squares::{Fitted, Task};
use crate::fit::scored::Scored;
use crate::gap::size::{root_mean, square_errors_over, square_wander};

/// The horizons that fit at least twice into the shortest check record, and the free run.
fn lengths(task: &Task<'_>, checks: &[usize]) -> Vec<Option<f64>> {
    let records = checks.iter().map(|&r| &task.dataset.records[r]);
    let shortest = records.map(|record| record.spacing_s * record.len() as f64).fold(f64::INFINITY, f64::min);
    let held = |seconds: &f64| *seconds == WINDOWS_S[0] || 2.0 * seconds <= shortest;
    WINDOWS_S.into_iter().filter(held).map(Some).chain([None]).collect()
}

/// Root mean square error of a model's predictions at one horizon, over the scale; `None` if it is not
/// finite.
pub(super) fn error(
    task: &Task<'_>,
    fitted: &Fitted,
    theta: &[f64],
    checks: &[usize],
    seconds: Option<f64>,
) -> Option<f64> {
    let squares = square_errors_over(task, &fitted.model, theta, checks, seconds)?;
    Some(root_mean(&squares)).filter(|error| error.is_finite())
}

/// Errors of the machine as given, calibrated and repaired, at every horizon.
pub(super) fn horizons(
    task: &Task<'_>,
    calibrated: &Scored,
    accepted: &Scored,
    checks: &[usize],
    floor: f64,
) -> Vec<Horizon> {
    let start = calibrated.fitted.model.start();
    let of = |seconds: Option<f64>| {
        let error = |fitted: &Fitted, theta: &[f64]| error(task, fitted, theta, checks, seconds);
        let Fitted { model, theta, .. } = &accepted.fitted;
        Horizon {
            seconds,
            before: error(&calibrated.fitted, &start),
            refit: error(&calibrated.fitted, &calibrated.fitted.theta),
            after: error(&accepted.fitted, &accepted.fitted.theta),
            floor,
            command_noise: root_mean(&square_wander(task, model, theta, checks, seconds)),
        }
    };
    lengths(task, checks).into_iter().map(of).collect()
}

/// Whether the predictions of machine `own` are worse than those of `other` at any horizon. `floor` is the
/// error that noise leaves.
pub(crate) fn worsens(task: &Task<'_>, other: &Scored, own: &Scored, checks: &[usize], floor: f64) -> bool {
    !worsened(&horizons(task, other, own, checks, floor), &Criteria::default()).is_empty()
}
