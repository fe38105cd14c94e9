//! How much any further cause could bring: what noise leaves, no cause explains.

use crate::dataset::scatter;
use crate::fit::least_squares::{Task, robust};
use crate::fit::odds::gain;
use crate::fit::search::Scored;

/// Scatter of the mean square of noise over an experiment, from its mean down.
const LEAST_NOISE: f64 = 0.97;

/// Largest evidence, nats, that a further cause can bring: on the check experiments, and on all. Infinite
/// if a balance of forces counts too.
pub(crate) fn room(task: &Task<'_>, scored: &Scored) -> [f64; 2] {
    if task.inverse.as_ref().is_some_and(|inverse| inverse.weight > 0.0) {
        return [f64::INFINITY; 2];
    }
    let dataset = task.dataset;
    let mut perfect = scored.clone();
    let rows = perfect.misfits.iter_mut().zip(&task.weights.sigma).zip(&dataset.records);
    for ((misfits, sigmas), record) in rows {
        for (c, (misfit, sigma)) in misfits.iter_mut().zip(sigmas).enumerate() {
            // Steps of an encoder leave nothing that a fit sees, and stated noise may be too large.
            let noise = dataset.channels[c].noise.min(scatter(&record.series[c]));
            *misfit = misfit.min(LEAST_NOISE * mean_loss(noise / sigma));
        }
    }
    let records = &dataset.records;
    let checks: Vec<usize> = (0..records.len()).filter(|&r| records[r].is_check).collect();
    let all: Vec<usize> = (0..records.len()).collect();
    [checks, all].map(|records| gain(&task.weights, scored, &perfect, &records))
}

/// Mean loss of normal noise of this many sigmas, by the Gauss-Hermite rule of three points.
fn mean_loss(sigmas: f64) -> f64 {
    robust(3.0_f64.sqrt() * sigmas).0 / 3.0
}
