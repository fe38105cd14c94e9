//! Size of the gap: short free predictions from the corrected state, compared with the measurements.

use feeler_plant::description::Machine;
use indexmap::IndexMap;
use rayon::prelude::*;

use crate::budget::Budget;
use crate::chance::Chance;
use crate::dataset::laps::lap;
use crate::dataset::{Channel, Dataset, Record};
use crate::fit::least_squares::Task;
use crate::fit::model::Model;
use crate::fit::wander::with_noise_again;
use crate::fit::weights::Weights;
use crate::predict::{Anchoring, Predictor, Start};
use crate::report::Gap;

/// Length of the free windows, s.
const WINDOW_S: f64 = 0.05;
/// Number of bootstrap draws.
const DRAWS: usize = 400;
/// A smaller gap counts as closed to the floor, to avoid ratios of tiny numbers.
const TINY: f64 = 1e-4;

fn window_rows(record: &Record) -> usize {
    rows_of(record, WINDOW_S)
}

fn rows_of(record: &Record, seconds: f64) -> usize {
    ((seconds / record.spacing_s).round() as usize).max(1)
}

/// Length nearest to that of a free window that divides a lap, so that the windows of all laps start alike.
/// `None` if there is none between half and twice the length.
fn rows_of_lap(record: &Record, lap: usize) -> Option<usize> {
    let rows = window_rows(record);
    (rows / 2..=2 * rows)
        .filter(|&own| own > 0 && lap.is_multiple_of(own))
        .min_by_key(|own| own.abs_diff(rows))
}

/// Predictions of a record in free windows of `rows` rows, one series per channel; `None` if the model has no
/// prediction.
fn predicted(
    task: &Task<'_>,
    model: &Model,
    theta: &[f64],
    record: &Record,
    rows: usize,
) -> Option<Vec<Vec<f64>>> {
    let assembly = model.assembly(theta, record.engagement)?;
    let mut predictor = Predictor::with(assembly, model.leeway(theta), task.dataset, record).ok()?;
    Some(predictor.follow(Anchoring::Continuous, Start::Windows(rows)).ok()?.series)
}

/// Errors of free windows of `rows` rows, one series per channel; `None` if the model has no prediction.
fn errors(task: &Task<'_>, model: &Model, theta: &[f64], r: usize, rows: usize) -> Option<Vec<Vec<f64>>> {
    let record = &task.dataset.records[r];
    let series = predicted(task, model, theta, record, rows)?;
    Some(series.iter().enumerate().map(|(c, series)| record.residual(c, series)).collect())
}

/// Mean square error over scale of each record in `records`, over all channels; `None` if the model has no
/// prediction.
pub(crate) fn square_errors(
    task: &Task<'_>,
    model: &Model,
    theta: &[f64],
    records: &[usize],
) -> Option<Vec<f64>> {
    square_errors_over(task, model, theta, records, Some(WINDOW_S))
}

/// Mean square errors of free predictions over a horizon in s, or over the whole record; otherwise as
/// [`square_errors`].
pub(crate) fn square_errors_over(
    task: &Task<'_>,
    model: &Model,
    theta: &[f64],
    records: &[usize],
    seconds: Option<f64>,
) -> Option<Vec<f64>> {
    let of = |&r: &usize| {
        let rows = rows_ahead(&task.dataset.records[r], seconds);
        over_scale(task, r, &errors(task, model, theta, r, rows)?)
    };
    records.par_iter().map(of).collect()
}

fn rows_ahead(record: &Record, seconds: Option<f64>) -> usize {
    seconds.map_or(record.len(), |seconds| rows_of(record, seconds))
}

/// Mean square over scale of the errors of a record, over all channels; `None` if it is not finite.
fn over_scale(task: &Task<'_>, r: usize, errors: &[Vec<f64>]) -> Option<f64> {
    let of = |(error, scale): (&Vec<f64>, &f64)| mean_square(error) / scale.powi(2).max(f64::MIN_POSITIVE);
    let mean = errors.iter().zip(&task.weights.scale[r]).map(of).sum::<f64>() / errors.len() as f64;
    mean.is_finite().then_some(mean)
}

/// Mean square error over scale, as [`square_errors_over`], that the noise of a measured command causes. It
/// is measured by adding noise of the same size again. Zero for machines with contacts, because any change
/// shifts the instants of impacts.
pub(crate) fn square_wander(
    task: &Task<'_>,
    model: &Model,
    theta: &[f64],
    records: &[usize],
    seconds: Option<f64>,
) -> Vec<f64> {
    if !task.dataset.machine.contacts.is_empty() {
        return vec![0.0; records.len()];
    }
    let of = |&r: &usize| {
        let record = &task.dataset.records[r];
        let again = with_noise_again(task.dataset, r)?;
        let rows = rows_ahead(record, seconds);
        let [a, b] = [record, &again].map(|record| predicted(task, model, theta, record, rows));
        let moved = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
        let moved: Vec<Vec<f64>> = a?.iter().zip(&b?).map(moved).collect();
        over_scale(task, r, &moved)
    };
    records.par_iter().map(|r| of(r).unwrap_or(0.0)).collect()
}

fn mean_square(series: &[f64]) -> f64 {
    series.iter().map(|x| x * x).sum::<f64>() / series.len().max(1) as f64
}

/// Standard deviation of every channel's noise: as stated, or more if repeated experiments differ by more. A
/// model error is equal in all repetitions and cancels in the difference of their errors. No model can
/// explain the part that does not repeat. The median over stretches of motion is used, so that an impact one
/// row later in one repetition has no effect. If no noise is stated, laps within a record count as
/// repetitions.
pub(crate) fn noise(task: &Task<'_>, model: &Model, theta: &[f64]) -> Vec<f64> {
    let stated = task.weights.noise.first().cloned().unwrap_or_default();
    let records = &task.dataset.records;
    let mut groups: IndexMap<&str, Vec<usize>> = IndexMap::new();
    for (r, record) in records.iter().enumerate() {
        if let Some(name) = &record.repeat {
            groups.entry(name).or_default().push(r);
        }
    }
    let mut stretches: Vec<Vec<f64>> = vec![Vec::new(); stated.len()];
    for pair in groups.values().flat_map(|group| group.windows(2)) {
        let rows = window_rows(&records[pair[0]]);
        let [Some(a), Some(b)] =
            [0, 1].map(|i| errors(task, model, theta, pair[i], window_rows(&records[pair[i]])))
        else {
            continue;
        };
        for (stretches, (a, b)) in stretches.iter_mut().zip(a.iter().zip(&b)) {
            stretches.extend(unrepeated(a, b, rows));
        }
    }
    let is_stated: Vec<bool> =
        task.dataset.channels.iter().map(|channel| task.dataset.is_noise_stated(&channel.column)).collect();
    if is_stated.contains(&false) {
        for (r, record) in records.iter().enumerate() {
            let Some((lap, rows)) = lap(record).and_then(|lap| Some((lap, rows_of_lap(record, lap)?))) else {
                continue;
            };
            let Some(errors) = errors(task, model, theta, r, rows) else { continue };
            for (c, series) in errors.iter().enumerate().filter(|(c, _)| !is_stated[*c]) {
                stretches[c].extend(unrepeated(series, &series[lap..], rows));
            }
        }
    }
    let of = |(stated, stretches): (&f64, &mut Vec<f64>)| {
        stretches.sort_by(f64::total_cmp);
        stretches.get(stretches.len() / 2).map_or(*stated, |middle| middle.sqrt().max(*stated))
    };
    stated.iter().zip(&mut stretches).map(of).collect()
}

/// Mean square per stretch of the part in which each of two repetitions differs from the other.
fn unrepeated(a: &[f64], b: &[f64], rows: usize) -> Vec<f64> {
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    difference.chunks_exact(rows).map(|stretch| 0.5 * mean_square(stretch)).collect()
}

/// Errors of short predictions due to noise alone.
pub(crate) struct Floors {
    /// Mean square over scale of each record, as [`square_errors`].
    pub(crate) square: Vec<f64>,
    /// Root mean square over scale due to the noise of the channels alone.
    pub(crate) read: f64,
}

impl Floors {
    /// Floors from the noise of every channel, as [`noise`], and from that of a measured command.
    pub(crate) fn of(
        task: &Task<'_>,
        model: &Model,
        theta: &[f64],
        noise: &[f64],
        records: &[usize],
    ) -> Self {
        let read = square_noise(task, noise, records);
        let commanded = square_wander(task, model, theta, records, Some(WINDOW_S));
        let square = read.iter().zip(commanded).map(|(read, commanded)| read + commanded).collect();
        Self { square, read: root_mean(&read) }
    }
}

/// Mean square over scale of each record that the noise of the channels leaves.
pub(crate) fn square_noise(task: &Task<'_>, noise: &[f64], records: &[usize]) -> Vec<f64> {
    let of = |(noise, scale): (&f64, &f64)| (noise / scale.max(f64::MIN_POSITIVE)).powi(2);
    let sum = |&r: &usize| noise.iter().zip(&task.weights.scale[r]).map(of).sum::<f64>();
    records.iter().map(|r| sum(r) / noise.len().max(1) as f64).collect()
}

/// Root of the mean of squares.
pub(crate) fn root_mean(squares: &[f64]) -> f64 {
    mean(squares).sqrt()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Share of the closable gap that `repaired` closes compared with `calibrated`, on a dataset that neither was
/// fitted to. It is the true closing, for comparison with the claimed one. `noise` is the standard deviation
/// of every column in that dataset. `None` if a machine has no prediction.
pub fn closing(
    dataset: &Dataset,
    calibrated: &Machine,
    repaired: &Machine,
    noise: &IndexMap<String, f64>,
) -> Option<f64> {
    let records: Vec<usize> = (0..dataset.records.len()).collect();
    let none = IndexMap::default();
    let of = |machine: &Machine| {
        let model = Model::calibration(machine, &none).ok()?;
        let start = model.start();
        let reference: Option<Vec<_>> = dataset
            .records
            .iter()
            .map(|record| {
                let assembly = model.assembly(&start, record.engagement)?;
                Predictor::with(assembly, model.leeway(&start), dataset, record).ok()?.anchored().ok()
            })
            .collect();
        let task = Task {
            dataset,
            weights: Weights::new(dataset, &reference?),
            fitted: Vec::new(),
            budget: Budget::unlimited(),
            inverse: None,
        };
        let errors = square_errors(&task, &model, &start, &records)?;
        let of = |channel: &Channel| noise.get(&channel.column).copied().unwrap_or(channel.noise);
        let noise: Vec<f64> = dataset.channels.iter().map(of).collect();
        Some((mean(&errors), mean(&Floors::of(&task, &model, &start, &noise, &records).square)))
    };
    let (refit, _) = of(calibrated)?;
    let (after, floor) = of(repaired)?;
    Some(closed(refit, after, floor))
}

fn closed(refit: f64, after: f64, floor: f64) -> f64 {
    // Noise is at most the error of the best model, even if repeated stretches differ by more.
    let floor = floor.min(after);
    let closable = refit - floor;
    if closable <= TINY * TINY {
        return 0.0;
    }
    1.0 - ((after - floor) / closable).sqrt()
}

/// The gap from square errors per check record.
pub(crate) fn gap(before: &[f64], refit: &[f64], after: &[f64], floor: &[f64]) -> Gap {
    let n = refit.len().max(1);
    let mean = |values: &[f64], pick: &[usize]| {
        pick.iter().map(|&i| values[i]).sum::<f64>() / pick.len().max(1) as f64
    };
    let all: Vec<usize> = (0..refit.len()).collect();
    let mut chance = Chance::default();
    let mut draws: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let pick: Vec<usize> = (0..n).map(|_| chance.pick(n)).collect();
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
