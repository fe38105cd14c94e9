//! How strongly the records speak for one model against another.
//!
//! Evidence is counted in stretches of motion, not in samples: each channel of each experiment counts as a
//! handful of independent looks at its mean square residual, and the looks compare logarithms, so that the
//! size of what no model explains cancels. A white-noise likelihood of all samples would make every
//! comparison certain, also the wrong ones.

use crate::dataset::scatter;
use crate::fit::least_squares::{Task, Weights, robust};
use crate::fit::scored::Scored;

/// Evidence on the check experiments that a cause must bring, nats.
pub(crate) const ACCEPT: f64 = 6.0;
/// Evidence on all experiments that it must bring, nats.
pub(crate) const ACCEPT_ALL: f64 = 15.0;
/// Evidence that an unknown more must bring, nats.
const PER_UNKNOWN: f64 = 1.5;
/// Mean squares below this are noise; differences there tell nothing.
const QUIET: f64 = 0.05;
/// Scatter of the mean square of noise over an experiment, from its mean down.
const LEAST_NOISE: f64 = 0.97;

/// Evidence for `new` against `old` over `records`, nats.
pub(crate) fn gain(weights: &Weights, old: &Scored, new: &Scored, records: &[usize]) -> f64 {
    let mut sum = 0.0;
    for &r in records {
        let looks = weights.looks[r];
        for (a, b) in old.misfits[r].iter().zip(&new.misfits[r]) {
            sum += 0.5 * looks * ((a + QUIET) / (b + QUIET)).ln();
        }
    }
    let unknowns = new.fitted.theta.len() as f64 - old.fitted.theta.len() as f64;
    sum - PER_UNKNOWN * unknowns
}

/// Probabilities from evidence in nats, softened by `temperature`.
pub(crate) fn probabilities(evidence: &[f64], temperature: f64) -> Vec<f64> {
    let best = evidence.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = evidence.iter().map(|e| ((e - best) / temperature).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

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
