//! Misfits that noise alone leaves.
//!
//! A model explains the records that it predicts itself. Noise and steps of the channels are added to these
//! records, and the model predicts them again. The rounding of readings, and the noise that corrections carry
//! from one channel to the others, then have their full effect.

use rayon::prelude::*;

use crate::budget::Stage;
use crate::chance::Chance;
use crate::dataset::rms;
use crate::fit::least_squares::{Fitted, Task};
use crate::predict::{Anchoring, Predictor, Start, in_steps};

/// Largest error of a free prediction that still moves like the record, as a share of the signal (root mean
/// square).
const ALIKE: f64 = 0.2;

/// Mean robust squared residual per record and channel of the model's own records with `noise`, the standard
/// deviation per record and channel. Zero for records whose motion the model does not predict. `None` if the
/// model has no prediction, or no time is left.
pub(crate) fn noise_alone(task: &Task<'_>, fitted: &Fitted, noise: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    if task.budget.is_over(Stage::Screen) {
        return None;
    }
    let records: Vec<usize> = (0..task.dataset.records.len()).collect();
    let of = |&r: &usize| synthetic(task, fitted, r, &noise[r]);
    let made: Vec<Option<Vec<Vec<f64>>>> = records.par_iter().map(of).collect();
    let mut dataset = task.dataset.clone();
    let mut alike = Vec::new();
    for (r, series) in made.into_iter().enumerate().filter_map(|(r, series)| Some((r, series?))) {
        dataset.records[r].series = series;
        alike.push(r);
    }
    let weights = task.weights.clone();
    let of_own = Task { dataset: &dataset, weights, fitted: records, budget: task.budget, inverse: None };
    let found = of_own.misfits(&fitted.model, &fitted.theta, &alike)?;
    let mut misfits = vec![vec![0.0; dataset.channels.len()]; dataset.records.len()];
    for (r, found) in alike.into_iter().zip(found) {
        misfits[r] = found;
    }
    Some(misfits)
}

/// The series of a record as the model predicts it freely, with noise and steps; `None` if that is another
/// motion.
fn synthetic(task: &Task<'_>, fitted: &Fitted, r: usize, noise: &[f64]) -> Option<Vec<Vec<f64>>> {
    let record = &task.dataset.records[r];
    let assembly = fitted.model.assembly(&fitted.theta, record.engagement)?;
    let leeway = fitted.model.leeway(&fitted.theta);
    let mut predictor = Predictor::with(assembly, leeway, task.dataset, record).ok()?;
    let mut series = predictor.follow(Anchoring::Never, Start::FirstRow).ok()?.smooth;
    let mut chance = Chance::seeded(r as u64);
    for (c, (series, channel)) in series.iter_mut().zip(&task.dataset.channels).enumerate() {
        let scale = task.weights.scale[r][c];
        let is_alike = rms(&record.residual(c, series)) <= (ALIKE * scale).hypot(channel.sigma());
        if scale.is_finite() && !is_alike {
            return None;
        }
        for x in series.iter_mut() {
            *x = in_steps(*x + noise[c] * chance.normal(), channel.resolution);
        }
    }
    Some(series)
}
