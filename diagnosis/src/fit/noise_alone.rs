//! Misfits that noise alone leaves.
//!
//! A model explains the records that it predicts itself. Noise and steps of the channels are added to these
//! records, and the model predicts them again. The rounding of readings, and the noise that corrections carry
//! from one channel to the others, then have their full effect.

use rayon::prelude::*;

use crate::budget::Stage;
use crate::chance::Chance;
use crate::dataset::{Dataset, Record};
use crate::fit::least_squares::{Fitted, Task};
use crate::predict::{Anchoring, Predictor, Start};

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
    let Fitted { model, theta, .. } = fitted;
    let made: Vec<Option<Record>> = (0..task.dataset.records.len())
        .into_par_iter()
        .map(|r| synthetic(task, fitted, r, &noise[r]))
        .collect();
    let is_alike: Vec<bool> = made.iter().map(Option::is_some).collect();
    let records =
        made.into_iter().zip(&task.dataset.records).map(|(made, real)| made.unwrap_or_else(|| real.clone()));
    let records: Vec<Record> = records.collect();
    let dataset = Dataset { records, ..task.dataset.clone() };
    let all: Vec<usize> = (0..dataset.records.len()).collect();
    let weights = task.weights.clone();
    let of_own = Task { dataset: &dataset, weights, fitted: all.clone(), budget: task.budget, inverse: None };
    let mut misfits = of_own.misfits(model, theta, &all)?;
    for (misfits, _) in misfits.iter_mut().zip(is_alike).filter(|(_, is_alike)| !is_alike) {
        misfits.fill(0.0);
    }
    Some(misfits)
}

/// The record as the model predicts it freely, with noise and steps; `None` if that is another motion.
fn synthetic(task: &Task<'_>, fitted: &Fitted, r: usize, noise: &[f64]) -> Option<Record> {
    let record = &task.dataset.records[r];
    let assembly = fitted.model.assembly(&fitted.theta, record.engagement)?;
    let leeway = fitted.model.leeway(&fitted.theta);
    let mut predictor = Predictor::with(assembly, leeway, task.dataset, record).ok()?;
    let smooth = predictor.follow(Anchoring::Never, Start::FirstRow).ok()?.smooth;
    let mut chance = Chance::seeded(r as u64);
    let mut made = record.clone();
    for (c, channel) in task.dataset.channels.iter().enumerate() {
        let scale = task.weights.scale[r][c];
        let errors = record.residual(c, &smooth[c]);
        let mean = errors.iter().map(|error| error * error).sum::<f64>() / errors.len().max(1) as f64;
        let most = (ALIKE * scale).hypot(channel.sigma());
        let is_alike = mean.sqrt() <= most;
        if scale.is_finite() && !is_alike {
            return None;
        }
        let read = |x: &f64| stepped(x + noise[c] * chance.normal(), channel.resolution);
        made.series[c] = smooth[c].iter().map(read).collect();
    }
    Some(made)
}

/// A reading in steps of `resolution`; as it is if that is zero.
fn stepped(reading: f64, resolution: f64) -> f64 {
    if resolution > 0.0 { (reading / resolution).round() * resolution } else { reading }
}
