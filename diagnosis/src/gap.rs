//! How large the gap is: short free predictions from the anchored state, against what was measured.

use feeler_plant::description::Machine;
use rayon::prelude::*;

use crate::dataset::Dataset;
use crate::fit::{Task, Weights};
use crate::model::Model;
use crate::predict::{Anchoring, Predictor, Start};
use crate::report::Gap;

/// Length of the free windows, s.
const WINDOW_S: f64 = 0.05;
/// Draws of the bootstrap.
const DRAWS: usize = 400;
/// Below this a gap counts as closed to the floor, so that a quotient of nothings is not quoted.
const TINY: f64 = 1e-4;

/// Mean square error over scale of each record in `records`, over all channels; none where the model has no prediction.
pub(crate) fn square_errors(task: &Task<'_>, model: &Model, theta: &[f64], records: &[usize]) -> Option<Vec<f64>> {
    records
        .par_iter()
        .map(|&r| {
            let record = &task.dataset.records[r];
            let assembly = model.assembly(theta, record.engagement)?;
            let rows = ((WINDOW_S / record.spacing_s).round() as usize).max(1);
            let prediction = Predictor::with(assembly, model.presliding(theta), task.dataset, record)
                .ok()?
                .follow(Anchoring::Continuous, Start::Windows(rows))
                .ok()?;
            let of = |c: usize| {
                let (m, p) = (&record.series[c], &prediction.series[c]);
                let sum: f64 = m.iter().zip(p).map(|(m, p)| (m - p).powi(2)).sum();
                sum / m.len() as f64 / task.weights.scale[r][c].powi(2).max(f64::MIN_POSITIVE)
            };
            let channels = record.series.len();
            let mean = (0..channels).map(of).sum::<f64>() / channels as f64;
            mean.is_finite().then_some(mean)
        })
        .collect()
}

/// Mean square of noise over scale, as [`square_errors`].
pub(crate) fn square_floors(task: &Task<'_>, records: &[usize]) -> Vec<f64> {
    records
        .iter()
        .map(|&r| {
            let terms = task.weights.noise[r].iter().zip(&task.weights.scale[r]);
            let n = task.weights.noise[r].len() as f64;
            terms.map(|(noise, scale)| (noise / scale.max(f64::MIN_POSITIVE)).powi(2)).sum::<f64>() / n
        })
        .collect()
}

/// Share of the closable gap that `repaired` closes against `calibrated` on the records of a dataset that neither was made with: the true closing, to
/// be held against the claimed one. None where a machine does not predict.
pub fn closing(dataset: &Dataset, calibrated: &Machine, repaired: &Machine) -> Option<f64> {
    let records: Vec<usize> = (0..dataset.records.len()).collect();
    let none = indexmap::IndexMap::default();
    let of = |machine: &Machine| {
        let model = Model::calibration(machine, &none).ok()?;
        let start = model.start();
        let reference: Option<Vec<_>> = dataset
            .records
            .iter()
            .map(|record| Predictor::new(model.assembly(&start, record.engagement)?, dataset, record).ok()?.anchored().ok())
            .collect();
        let task = Task { dataset, weights: Weights::new(dataset, &reference?), fitted: Vec::new() };
        let errors = square_errors(&task, &model, &start, &records)?;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        Some((mean(&errors), mean(&square_floors(&task, &records))))
    };
    let (refit, floor) = of(calibrated)?;
    let (after, _) = of(repaired)?;
    Some(closed(refit, after, floor))
}

fn closed(refit: f64, after: f64, floor: f64) -> f64 {
    let closable = refit - floor;
    if closable <= TINY * TINY {
        return 0.0;
    }
    1.0 - ((after - floor).max(0.0) / closable).sqrt()
}

/// The gap from square errors per check record.
pub(crate) fn gap(before: &[f64], refit: &[f64], after: &[f64], floor: &[f64]) -> Gap {
    let n = refit.len().max(1);
    let mean = |values: &[f64], pick: &[usize]| pick.iter().map(|&i| values[i]).sum::<f64>() / pick.len().max(1) as f64;
    let all: Vec<usize> = (0..refit.len()).collect();
    // A small generator is enough for a bootstrap, and makes it repeatable.
    let mut seed: u64 = 0x9E37_79B9_7F4A_7C15;
    let mut draws: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let pick: Vec<usize> = (0..n)
                .map(|_| {
                    seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    (seed >> 33) as usize % n
                })
                .collect();
            closed(mean(refit, &pick), mean(after, &pick), mean(floor, &pick))
        })
        .collect();
    draws.sort_by(f64::total_cmp);
    let [r, a, f] = [refit, after, floor].map(|values| mean(values, &all));
    Gap {
        before: mean(before, &all).sqrt(),
        refit: r.sqrt(),
        after: a.sqrt(),
        floor: f.sqrt(),
        closed: closed(r, a, f),
        closed_ci90: [draws[DRAWS / 20], draws[DRAWS - 1 - DRAWS / 20]],
    }
}
