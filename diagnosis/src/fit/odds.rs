//! Evidence of the records for one model over another.
//!
//! Evidence counts stretches of motion, not readings. Each channel of each experiment counts as a few
//! independent samples of its mean square residual. Logarithms are compared, so that the common unexplained
//! part cancels. A white-noise likelihood of all readings would make every comparison certain, even wrong
//! ones.

use crate::dataset::scatter_of;
use crate::fit::least_squares::{Task, robust};
use crate::fit::noise_alone::noise_alone;
use crate::fit::scored::Scored;
use crate::fit::weights::Weights;

/// Evidence on the check experiments that a cause needs to be accepted, nats.
pub(crate) const ACCEPT: f64 = 6.0;
/// Evidence on all experiments that a cause needs to be accepted, nats.
pub(crate) const ACCEPT_ALL: f64 = 15.0;
/// Additional evidence for each further unknown, nats.
const PER_UNKNOWN: f64 = 1.5;
/// Smaller mean squares are noise, and their differences carry no information.
const QUIET: f64 = 0.05;
/// Lowest mean square of noise over an experiment, relative to its expectation.
const LEAST_NOISE: f64 = 0.97;
/// Largest mean square that noise may leave by rounding and by corrections, over that of the noise itself.
const MOST_NOISE: f64 = 1.5;

/// Evidence for `new` over `old` on `records`, nats.
pub(crate) fn gain(weights: &Weights, old: &Scored, new: &Scored, records: &[usize]) -> f64 {
    let mut sum = 0.0;
    for &r in records {
        for ((a, b), looks) in old.misfits[r].iter().zip(&new.misfits[r]).zip(&weights.looks[r]) {
            sum += 0.5 * looks * ((a + QUIET) / (b + QUIET)).ln();
        }
        for coarse in &weights.coarse {
            let looks = &weights.looks[r];
            sum += coarse.evidence(&new.causes, looks) - coarse.evidence(&old.causes, looks);
        }
    }
    let unknowns = new.fitted.theta.len() as f64 - old.fitted.theta.len() as f64;
    sum - PER_UNKNOWN * unknowns
}

/// Evidence for one set of causes over another on some records, nats. It counts predictions, and the balance
/// of forces if that covers both sets.
pub(crate) fn evidence(task: &Task<'_>, old: &Scored, new: &Scored, records: &[usize]) -> f64 {
    let predicted = gain(&task.weights, old, new, records);
    let (Some(inverse), Some(old), Some(new)) = (&task.inverse, &old.balanced, &new.balanced) else {
        return predicted;
    };
    let is_check = |r: usize| task.dataset.records[r].is_check;
    let looks = |is_counted: &dyn Fn(usize) -> bool| {
        let counted = task.weights.looks.iter().enumerate().filter(|(r, _)| is_counted(*r));
        counted.map(|(_, looks)| looks.iter().copied().fold(0.0, f64::max)).sum::<f64>()
    };
    // The balance has evidence on the check experiments only, so it is scaled up for all.
    let is_all = records.iter().any(|&r| !is_check(r));
    let times = if is_all { looks(&|_| true) / looks(&is_check).max(1.0) } else { 1.0 };
    (1.0 - inverse.weight) * predicted + inverse.weight * times * (new.nats - old.nats)
}

/// Probabilities from evidence in nats, softened by `temperature`.
pub(crate) fn probabilities(evidence: &[f64], temperature: f64) -> Vec<f64> {
    let best = evidence.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = evidence.iter().map(|e| ((e - best) / temperature).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

/// Largest evidence that a further cause can gain, nats: on the check experiments, and on all. Infinite if a
/// balance of forces resolves less than the noise of predictions.
pub(crate) fn room(task: &Task<'_>, scored: &Scored) -> [f64; 2] {
    room_above(task, scored, |_| None)
}

/// The room above all that noise leaves: also what rounding and corrections make of it.
pub(crate) fn room_above_noise(task: &Task<'_>, scored: &Scored) -> [f64; 2] {
    room_above(task, scored, |noise| noise_alone(task, &scored.fitted, noise))
}

/// The room above noise. `alone` gives the misfits per record and channel that noise of these standard
/// deviations leaves; without it noise leaves its own mean square.
fn room_above(
    task: &Task<'_>,
    scored: &Scored,
    alone: impl Fn(&[Vec<f64>]) -> Option<Vec<Vec<f64>>>,
) -> [f64; 2] {
    if task.inverse.as_ref().is_some_and(|inverse| inverse.weight > 0.0 && inverse.is_noisy) {
        return [f64::INFINITY; 2];
    }
    let dataset = task.dataset;
    let (mut perfect, mut noises, mut most) = (scored.clone(), Vec::new(), Vec::new());
    for (r, (misfits, record)) in perfect.misfits.iter_mut().zip(&dataset.records).enumerate() {
        // Encoder steps do not count here, since a fit ignores them. Stated noise may be too large.
        let noise = |c: usize| dataset.channels[c].noise.min(scatter_of(record, c));
        let noise: Vec<f64> = (0..misfits.len()).map(noise).collect();
        let steps = dataset.channels.iter().map(|channel| channel.resolution / 12.0_f64.sqrt());
        let with_steps = |join: fn(f64, f64) -> f64| -> Vec<f64> {
            noise.iter().zip(steps.clone()).map(|(noise, step)| join(*noise, step)).collect()
        };
        // In the difference of two encoders the steps count.
        let (larger, both) = (with_steps(f64::max), with_steps(f64::hypot));
        for (c, misfit) in misfits.iter_mut().enumerate() {
            let loss = |noise| {
                LEAST_NOISE * mean_loss(task.weights.noise_of(r, c, noise) / task.weights.sigma[r][c])
            };
            *misfit = loss(if task.weights.against[r][c].is_some() { &larger } else { &noise });
            most.push(MOST_NOISE * loss(&both));
        }
        noises.push(noise);
    }
    if let Some(alone) = alone(&noises) {
        let least = perfect.misfits.iter_mut().flatten();
        for ((least, alone), most) in least.zip(alone.iter().flatten()).zip(most) {
            *least = least.max((LEAST_NOISE * alone).min(most));
        }
    }
    for (least, misfit) in perfect.misfits.iter_mut().flatten().zip(scored.misfits.iter().flatten()) {
        *least = least.min(*misfit);
    }
    let records = &dataset.records;
    let checks: Vec<usize> = (0..records.len()).filter(|&r| records[r].is_check).collect();
    let all: Vec<usize> = (0..records.len()).collect();
    [checks, all].map(|records| gain(&task.weights, scored, &perfect, &records))
}

/// Mean loss of normal noise with this deviation in sigmas, by the three-point Gauss-Hermite rule.
fn mean_loss(sigmas: f64) -> f64 {
    robust(3.0_f64.sqrt() * sigmas).0 / 3.0
}
