//! How much any further cause could bring: what noise leaves, no cause explains.

use crate::fit::least_squares::{Task, robust};
use crate::fit::odds::gain;
use crate::fit::search::Scored;
use crate::gap::size::noise;

/// Scatter of the mean square of noise over an experiment, from its mean down.
const LEAST_NOISE: f64 = 0.97;
/// A channel that shows less than this share of its noise has less noise than stated.
const LESS_THAN_STATED: f64 = 0.7;

/// Largest evidence, nats, that a further cause can bring: on the check experiments, and on all. Infinite
/// if a balance of forces counts too.
pub(crate) fn room(task: &Task<'_>, scored: &Scored) -> [f64; 2] {
    if task.inverse.as_ref().is_some_and(|inverse| inverse.weight > 0.0) {
        return [f64::INFINITY; 2];
    }
    let noise = noise(task, &scored.fitted.model, &scored.fitted.theta);
    let mut perfect = scored.clone();
    for (misfits, sigmas) in perfect.misfits.iter_mut().zip(&task.weights.sigma) {
        for ((misfit, sigma), noise) in misfits.iter_mut().zip(sigmas).zip(&noise) {
            let floor = mean_loss(noise / sigma);
            *misfit = if *misfit < LESS_THAN_STATED * floor { 0.0 } else { misfit.min(LEAST_NOISE * floor) };
        }
    }
    let records = &task.dataset.records;
    let checks: Vec<usize> = (0..records.len()).filter(|&r| records[r].is_check).collect();
    let all: Vec<usize> = (0..records.len()).collect();
    [checks, all].map(|records| gain(&task.weights, scored, &perfect, &records))
}

/// Mean loss of normal noise of this many sigmas, by the Gauss-Hermite rule of three points.
fn mean_loss(sigmas: f64) -> f64 {
    robust(3.0_f64.sqrt() * sigmas).0 / 3.0
}
