//! How strongly the records speak for one model against another.
//!
//! Evidence is counted in stretches of motion, not in samples: each channel of each experiment counts as a
//! handful of independent looks at its mean square residual, and the looks compare logarithms, so that the
//! size of what no model explains cancels. A white-noise likelihood of all samples would make every
//! comparison certain, also the wrong ones.

use crate::fit::least_squares::Weights;
use crate::fit::search::Scored;

/// Evidence on the check experiments that a cause must bring, nats.
pub(crate) const ACCEPT: f64 = 6.0;
/// Evidence on all experiments that it must bring, nats.
pub(crate) const ACCEPT_ALL: f64 = 15.0;
/// Evidence that an unknown more must bring, nats.
const PER_UNKNOWN: f64 = 1.5;
/// Mean squares below this are noise; differences there tell nothing.
const QUIET: f64 = 0.05;

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
