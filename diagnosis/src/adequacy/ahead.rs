//! Prediction errors at each horizon.

use super::criteria::Criteria;
use super::horizons::{Horizon, WINDOWS_S, worsened};
use crate::fit::least_squares::{Fitted, Task};
use crate::fit::scored::Scored;
use crate::gap::size::{noise, root_mean, square_errors_over, square_noise, square_wander};

/// The check records into which a horizon fits at least twice: all for the shortest one and for the free run.
fn long_enough(task: &Task<'_>, checks: &[usize], seconds: Option<f64>) -> Vec<usize> {
    let least = seconds.filter(|seconds| *seconds > WINDOWS_S[0]).map_or(0.0, |seconds| 2.0 * seconds);
    let length = |r: usize| task.dataset.records[r].spacing_s * task.dataset.records[r].len() as f64;
    checks.iter().copied().filter(|&r| length(r) >= least).collect()
}

/// Root mean square error of a model's predictions at one horizon, over the scale, on the check records that
/// are long enough; `None` if it is not finite.
pub(super) fn error(
    task: &Task<'_>,
    fitted: &Fitted,
    theta: &[f64],
    checks: &[usize],
    seconds: Option<f64>,
) -> Option<f64> {
    let checks = long_enough(task, checks, seconds);
    let squares = square_errors_over(task, &fitted.model, theta, &checks, seconds)?;
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
        let long = long_enough(task, checks, seconds);
        Horizon {
            seconds,
            before: error(&calibrated.fitted, &start),
            refit: error(&calibrated.fitted, &calibrated.fitted.theta),
            after: error(&accepted.fitted, &accepted.fitted.theta),
            floor: if long.len() == checks.len() {
                floor
            } else {
                root_mean(&square_noise(task, &noise(task, model, theta), &long))
            },
            command_noise: root_mean(&square_wander(task, model, theta, &long, seconds)),
        }
    };
    let lengths = WINDOWS_S.into_iter().map(Some).chain([None]);
    lengths.filter(|seconds| !long_enough(task, checks, *seconds).is_empty()).map(of).collect()
}

/// Whether the predictions of machine `own` are worse than those of `other` at any horizon. `floor` is the
/// error that noise leaves.
pub(crate) fn worsens(task: &Task<'_>, other: &Scored, own: &Scored, checks: &[usize], floor: f64) -> bool {
    !worsened(&horizons(task, other, own, checks, floor), &Criteria::default()).is_empty()
}
