//! Standard deviations of fitted values under correlated residuals: model errors are not white noise.
//!
//! Four estimates are made, and the largest counts. The fourth counts only where the cost is flat:
//!
//! - **The information of the readings.** A residual counts with the variance of its mean, which its
//!   correlation from row to row determines, and with at least the noise. The normal matrix with these
//!   weights gives the first estimate.
//! - **The actual residuals.** Their effect on the values follows from the fit, block by block of motion.
//!   This is the sandwich of Huber and White, with blocks as clusters (Cameron and Miller, A Practitioner's
//!   Guide to Cluster-Robust Inference, Journal of Human Resources 50, 2015).
//! - **The differences between experiments.** This is the sandwich with whole records as clusters, including
//!   those that were not fitted. A slightly wrong law shifts values one way in one motion, and the other way
//!   in another. In the fitted records the fit hides part of this, in the others it does not.
//! - **The cost itself**, by steps along the deviation that the cost indicates, with residuals constant over
//!   whole stretches. Where impacts make slopes steep, the cost rises less than the slopes indicate.
//!

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::fit::curvature::{add_curvature, add_gradient, times};
use crate::fit::least_squares::{Fitted, Task, robust};
use crate::fit::shared_scale::without;
use crate::fit::walk::{cost, stretch};

/// Smallest number of blocks over all fitted records, and per unknown: a fit removes the effect of as many
/// blocks as it has unknowns.
const BLOCKS: usize = 12;
const BLOCKS_PER_UNKNOWN: usize = 3;
/// Smallest number of records whose differences give a standard deviation.
const RECORDS: usize = 4;

/// Length of the windows that show the correlation of a residual, in stretches of motion.
const STRETCHES: f64 = 2.0;
/// Smallest variance of a reading, in sigmas of its channel.
const LEAST_VARIANCE: f64 = 1e-6;

/// Standard deviations of every unknown.
pub(crate) struct Deviations {
    /// As stated in intervals.
    pub(crate) stated: Vec<f64>,
    /// At least those of the fit, and of residuals that are constant over stretches. They decide whether a
    /// cause may be absent: with the stated ones a machine without any was accused of a dead band.
    pub(crate) cautious: Vec<f64>,
}

/// The contribution of one record.
struct Part {
    /// Curvature of the cost.
    curvature: DMatrix<f64>,
    /// Curvature with each reading weighted by its information.
    worth: DMatrix<f64>,
    /// Curvature with readings weighted as if the rest of a residual were constant over whole stretches.
    least: DMatrix<f64>,
    /// Weight of a reading of each channel in `least`.
    per_reading: Vec<f64>,
    /// Gradient from the residuals of each block.
    pulls: Vec<DVector<f64>>,
}

impl Part {
    /// Outer product of the gradient from the whole record.
    fn of_record(&self) -> DMatrix<f64> {
        let whole: DVector<f64> = self.pulls.iter().sum();
        &whole * whole.transpose()
    }
}

/// Standard deviation of every unknown of a fitted model. `None` if the model has no prediction or the
/// records hold no information.
pub(crate) fn deviations(task: &Task<'_>, fitted: &Fitted) -> Option<Deviations> {
    let n = fitted.theta.len();
    let each = BLOCKS.max(BLOCKS_PER_UNKNOWN * n).div_ceil(task.fitted.len().max(1));
    let scale = task.shared_scale(&fitted.model, &fitted.theta);
    let still = scale.map_or_else(Vec::new, |scale| scale.direction(&fitted.model, &fitted.theta));
    let of = |r: usize| part(task, fitted, &still, r, each);
    let parts: Option<Vec<Part>> = task.fitted.par_iter().map(|&r| of(r)).collect();
    let (mut bread, mut worth, mut least) =
        (DMatrix::zeros(n, n), DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let (mut filling, mut between) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let (mut blocks, mut per_reading) = (0.0_f64, Vec::new());
    for part in parts? {
        bread += &part.curvature;
        worth += &part.worth;
        least += &part.least;
        between += part.of_record();
        per_reading.push(part.per_reading);
        for pull in part.pulls {
            filling += &pull * pull.transpose();
            blocks += 1.0;
        }
    }
    let records = task.dataset.records.len();
    let checks: Vec<usize> = (0..records).filter(|r| !task.fitted.contains(r)).collect();
    // A check record that the model cannot predict carries no information about values.
    let others: Vec<DMatrix<f64>> = checks.par_iter().filter_map(|&r| Some(of(r)?.of_record())).collect();
    let known = task.fitted.len() + others.len();
    for other in others {
        between += other;
    }
    between *= if known < RECORDS { 0.0 } else { task.fitted.len() as f64 / known as f64 };
    let priors: Vec<f64> = (fitted.model.unknowns.iter())
        .map(|unknown| unknown.prior.map_or(0.0, |(_, sigma)| sigma.powi(-2)))
        .collect();
    for (i, prior) in priors.iter().enumerate() {
        // A small term keeps the matrix regular for unknowns without influence.
        for curvature in [&mut bread, &mut worth, &mut least] {
            curvature[(i, i)] += prior + 1e-9;
        }
    }
    let inverse = bread.try_inverse()?;
    // Number of values that the records determine, rather than the priors.
    let determined: f64 = priors.iter().enumerate().map(|(i, prior)| 1.0 - prior * inverse[(i, i)]).sum();
    filling *= blocks / (blocks - determined.max(1.0)).max(1.0);
    for (i, prior) in priors.iter().enumerate() {
        filling[(i, i)] += prior;
    }
    let [lasting, between] = [filling, between].map(|pulls| &inverse * pulls * &inverse);
    let plain = worth.try_inverse()?;
    let along = least.try_inverse()?;
    let here = cost(task, fitted, &per_reading, &fitted.theta);
    let deviation = |i: usize| {
        let own = along[(i, i)].max(0.0).sqrt();
        let step: Vec<f64> = along.column(i).iter().map(|with| with / own.max(f64::MIN_POSITIVE)).collect();
        let is_sought = fitted.model.unknowns[i].is_of_effect();
        let here = here.filter(|_| is_sought);
        let stretch = here.map_or(1.0, |here| stretch(task, fitted, &per_reading, here, i, &step));
        let flat = if stretch > 1.0 { stretch * own } else { 0.0 };
        let found = [&plain, &lasting, &between].map(|variances| variances[(i, i)].max(0.0).sqrt());
        let stated = found.into_iter().fold(flat, f64::max);
        (stated, stated.max(stretch * own).max(fitted.sigma[i]))
    };
    let (stated, cautious): (Vec<f64>, Vec<f64>) = (0..n).into_par_iter().map(deviation).unzip();
    stated.iter().all(|deviation| deviation.is_finite()).then_some(Deviations { stated, cautious })
}

/// The contribution of record `r`, divided into blocks. `still` is a direction in the unknowns that changes
/// no measured signal; empty if there is none.
fn part(task: &Task<'_>, fitted: &Fitted, still: &[f64], r: usize, blocks: usize) -> Option<Part> {
    let n = fitted.theta.len();
    let here = task.predict(&fitted.model, &fitted.theta, r)?;
    let moved: Vec<_> = (0..n).map(|i| task.moved(&fitted.model, &fitted.theta, i, r)).collect();
    let mut part = Part {
        curvature: DMatrix::zeros(n, n),
        worth: DMatrix::zeros(n, n),
        least: DMatrix::zeros(n, n),
        per_reading: vec![0.0; task.dataset.channels.len()],
        pulls: vec![DVector::zeros(n); blocks],
    };
    for (c, measured) in task.dataset.records[r].series.iter().enumerate() {
        if task.weights.sigma[r][c].is_infinite() {
            continue;
        }
        let mut slopes = task.slopes(r, c, &here, &moved);
        without(still, &mut slopes);
        let residuals = task.residuals(r, c, &here);
        let weights = task.robust_weights(r, c, &residuals);
        let factor = task.share(r, c);
        let [worth, least] = worth(task, r, c, &residuals);
        part.per_reading[c] = least;
        // Only residuals beyond the dead zone move the fit.
        let beyond = task.weights_beyond(r, c, &here, &residuals);
        add_curvature(&mut part.curvature, factor, &slopes, &beyond);
        add_curvature(&mut part.worth, worth, &slopes, &weights);
        add_curvature(&mut part.least, least, &slopes, &weights);
        let weighted = times(&residuals, &weights);
        let rows = measured.len().div_ceil(blocks).max(1);
        for (pull, block) in part.pulls.iter_mut().zip((0..measured.len()).step_by(rows)) {
            let end = (block + rows).min(measured.len());
            let own: Vec<Vec<f64>> = slopes.iter().map(|slope| slope[block..end].to_vec()).collect();
            add_gradient(pull, factor, &own, &weighted[block..end]);
        }
    }
    Some(part)
}

/// Weight of a reading of a channel with these residuals: by their correlation, and as if all but noise were
/// constant over stretches. The latter is at most its weight in the cost.
fn worth(task: &Task<'_>, r: usize, c: usize, residuals: &[f64]) -> [f64; 2] {
    let weights = &task.weights;
    let readings = task.dataset.records[r].count(c) as f64;
    let looks = weights.looks[r][c];
    let misfit = residuals.iter().map(|&residual| robust(residual).0).sum::<f64>() / readings;
    let noise = weights.noise_of(r, c, &weights.noise[r]);
    let noise = (noise / weights.sigma[r][c]).powi(2);
    let window = STRETCHES * residuals.len() as f64 / looks;
    let mean = long_run(residuals, readings, window as usize).max(noise).max(LEAST_VARIANCE);
    let noise = noise.min(misfit);
    [mean.recip(), task.share(r, c).min(once_per_look(noise, misfit - noise, readings / looks))]
}

/// Variance of the mean of correlated residuals, times the number of readings, from the sums over all windows
/// of `rows` rows. These are overlapping batch means (Meketon and Schmeiser, Winter Simulation Conference
/// 1984).
fn long_run(residuals: &[f64], readings: f64, rows: usize) -> f64 {
    let rows = rows.clamp(1, residuals.len().max(1));
    let sums: Vec<f64> = std::iter::once(0.0)
        .chain(residuals.iter().scan(0.0, |sum, residual| {
            *sum += residual;
            Some(*sum)
        }))
        .collect();
    let windows = sums.iter().zip(&sums[rows..]).map(|(from, to)| (to - from).powi(2));
    let mean = windows.sum::<f64>() / (sums.len() - rows) as f64;
    mean / rows as f64 * residuals.len() as f64 / readings
}

/// Information of a reading. Its error has one part with the variance `new` that is independent in every row,
/// and one with the variance `lasting` that is constant over `rows` rows.
fn once_per_look(new: f64, lasting: f64, rows: f64) -> f64 {
    (new + lasting * rows).max(f64::MIN_POSITIVE).recip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    /// The mean of `n` errors `e_k + m_j`, with one `m` for each stretch of `rows` rows, has the variance
    /// `(new + lasting rows) / n`.
    #[test]
    fn truth_information_of_lasting_errors_is_that_of_their_mean() {
        let (new, lasting, rows, stretches): (f64, f64, usize, usize) = (1.0, 0.25, 20, 400);
        let mut chance = Chance::seeded(7);
        let mut series = || -> Vec<f64> {
            let of_stretch = |_| {
                let common = lasting.sqrt() * chance.deviate();
                (0..rows).map(|_| new.sqrt() * chance.deviate() + common).collect::<Vec<f64>>()
            };
            (0..stretches).flat_map(of_stretch).collect()
        };
        let n = (rows * stretches) as f64;
        let draws: u32 = 400;
        let (mut variance, mut estimate) = (0.0, 0.0);
        for _ in 0..draws {
            let series = series();
            variance += (series.iter().sum::<f64>() / n).powi(2) / f64::from(draws);
            estimate += long_run(&series, n, STRETCHES as usize * rows) / f64::from(draws);
        }
        let expected = once_per_look(new, lasting, rows as f64).recip();
        // 400 draws determine a variance to 7 %. With white noise alone the result would be off by a factor
        // of five.
        assert!((variance * n / expected - 1.0).abs() < 0.25, "{variance} against {expected}");
        // A window over `k` stretches misses `1 / 3k` of their correlation.
        let seen = new + lasting * rows as f64 * (1.0 - 1.0 / (3.0 * STRETCHES));
        assert!((estimate / seen - 1.0).abs() < 0.02, "{estimate} against {seen}");
    }

    #[test]
    fn truth_readings_that_are_missing_carry_no_information() {
        // Errors that last for a hundred rows; nine of ten rows are empty.
        let mut chance = Chance::seeded(3);
        let errors: Vec<f64> = (0..400).flat_map(|_| [chance.deviate(); 100]).collect();
        let read = errors.iter().enumerate().map(|(k, error)| if k % 10 == 0 { *error } else { 0.0 });
        let read: Vec<f64> = read.collect();
        let [all, tenth] = [(errors, 4e4), (read, 4e3)].map(|(series, n)| long_run(&series, n, 200));
        // The same errors are known from a tenth of the readings, each of which counts ten times.
        assert!((10.0 * tenth / all - 1.0).abs() < 0.01, "{all} {tenth}");
        assert!(all > 50.0, "{all}");
    }
}
