//! Misfits that noise alone leaves.
//!
//! A model explains the records that it predicts itself. Noise and steps of the channels are added to these
//! records, and the model predicts them again. The rounding of readings, and the noise that corrections carry
//! from one channel to the others, then have their full effect.

use rayon::prelude::*;

use crate::chance::Chance;
use crate::dataset::{Dataset, Record};
use crate::fit::least_squares::{Fitted, Task};
use crate::predict::{Anchoring, Predictor, Start};

/// Mean robust squared residual per record and channel of the model's own records with `noise`, the standard
/// deviation per record and channel. `None` if the model has no prediction.
pub(crate) fn noise_alone(task: &Task<'_>, fitted: &Fitted, noise: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let Fitted { model, theta, .. } = fitted;
    let own = |(r, record): (usize, &Record)| {
        let assembly = model.assembly(theta, record.engagement)?;
        let mut predictor = Predictor::with(assembly, model.leeway(theta), task.dataset, record).ok()?;
        let smooth = predictor.follow(Anchoring::Never, Start::FirstRow).ok()?.smooth;
        let mut chance = Chance::seeded(r as u64);
        let mut own = record.clone();
        for (c, channel) in task.dataset.channels.iter().enumerate() {
            let read = |x: &f64| stepped(x + noise[r][c] * chance.normal(), channel.resolution);
            own.series[c] = smooth[c].iter().map(read).collect();
        }
        Some(own)
    };
    let records: Option<Vec<Record>> = task.dataset.records.par_iter().enumerate().map(own).collect();
    let dataset = Dataset { records: records?, ..task.dataset.clone() };
    let all: Vec<usize> = (0..dataset.records.len()).collect();
    let task = Task {
        dataset: &dataset,
        weights: task.weights.clone(),
        fitted: all.clone(),
        budget: task.budget,
        inverse: None,
    };
    task.misfits(model, theta, &all)
}

/// A reading in steps of `resolution`; as it is if that is zero.
fn stepped(reading: f64, resolution: f64) -> f64 {
    if resolution > 0.0 { (reading / resolution).round() * resolution } else { reading }
}
