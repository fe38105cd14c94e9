//! Fits unknowns to records by the Levenberg-Marquardt method, with bounds, priors and a robust loss.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::budget::{Budget, Stage};
use crate::dataset::{Dataset, Record};
use crate::fit::bounded::minimise;
use crate::fit::coarse::Coarse;
use crate::fit::curvature::{add_curvature, add_gradient, times};
use crate::fit::elongation::{Against, against};
use crate::fit::model::Model;
use crate::fit::shared_scale::{SharedScale, without};
use crate::fit::unknown::Unknown;
use crate::fit::wander::{commanded_acceleration, wander};
use crate::inverse::Inverse;
use crate::predict::{Prediction, Predictor};

/// Independent pieces of evidence in one channel of one experiment. There are many samples, but a model error
/// lasts over whole stretches of motion.
pub(crate) const PIECES: f64 = 100.0;
/// Residuals beyond this many sigmas enter the cost linearly.
const ROBUST_SIGMAS: f64 = 8.0;
/// Share of a channel's variation that no model is expected to explain.
const DISCREPANCY: f64 = 0.01;
/// Share of a motion to which the readings of two sensors agree on a rigid joint: their scales differ.
const AGREEMENT: f64 = 1e-4;
/// Smallest scale of a channel in one experiment, as a share of its variation over all experiments.
const SMALLEST_SCALE: f64 = 0.1;
/// Smallest damping of a step.
const LEAST_DAMPING: f64 = 1e-9;
/// A fit has converged if a step reduces the cost by less than this: a hundredth of the cost of one unknown.
const CONVERGED: f64 = 0.02;
/// The same as a share of the cost. The differences that separate models are far larger.
const CONVERGED_SHARE: f64 = 1e-5;

/// Independent samples per channel and second of motion: errors of a model last about a tenth of a second.
const LOOKS_PER_S: f64 = 8.0;
/// Independent samples per radian if only positions correct a prediction: errors last as long as the memory
/// of the observer.
const LOOKS_PER_RADIAN: f64 = 0.2;
/// Smallest number of independent samples of an experiment, and of rows per sample.
const FEWEST_LOOKS: f64 = 4.0;
const ROWS_PER_LOOK: f64 = 10.0;
/// Scales of the residuals, per record and channel.
#[derive(Clone, Debug)]
pub(crate) struct Weights {
    /// One sigma of noise.
    pub(crate) noise: Vec<Vec<f64>>,
    /// Root mean square of the variation.
    pub(crate) scale: Vec<Vec<f64>>,
    /// Divisor of a residual.
    pub(crate) sigma: Vec<Vec<f64>>,
    /// Number of independent samples.
    pub(crate) looks: Vec<Vec<f64>>,
    /// The channel from which another one is weighed as a difference; `None` for one weighed by itself.
    pub(super) against: Vec<Vec<Option<Against>>>,
    /// Stated resolutions that the readings contradict.
    pub(crate) coarse: Vec<Coarse>,
}

impl Weights {
    pub(crate) fn new(dataset: &Dataset, reference: &[Prediction]) -> Self {
        let channels = dataset.channels.len();
        let variation = |(series, silent): (&Vec<f64>, &bool)| {
            if *silent || series.iter().all(|x| x.to_bits() == series[0].to_bits()) {
                return 0.0;
            }
            let mean = series.iter().sum::<f64>() / series.len() as f64;
            (series.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / series.len() as f64).sqrt()
        };
        let own: Vec<Vec<f64>> = dataset
            .records
            .iter()
            .map(|record| record.series.iter().zip(&record.silent).map(variation).collect())
            .collect();
        let pooled: Vec<f64> = (0..channels)
            .map(|c| (own.iter().map(|o: &Vec<f64>| o[c].powi(2)).sum::<f64>() / own.len() as f64).sqrt())
            .collect();
        // A channel that never changes carries no information, however wrong its prediction is.
        let scale =
            |own: f64, pooled: f64| if own > 0.0 { own.max(SMALLEST_SCALE * pooled) } else { f64::INFINITY };
        let scale: Vec<Vec<f64>> = own
            .iter()
            .map(|own| own.iter().zip(&pooled).map(|(&own, &pooled)| scale(own, pooled)).collect())
            .collect();
        let noise: Vec<Vec<f64>> = dataset
            .records
            .iter()
            .map(|_| {
                dataset
                    .channels
                    .iter()
                    .map(|c| (c.noise.powi(2) + c.resolution.powi(2) / 12.0).sqrt())
                    .collect()
            })
            .collect();
        // The anchored prediction of a position differs from its reading only by the effect of an
        // acceleration error within the memory of the observer.
        let is_position: Vec<bool> = dataset
            .channels
            .iter()
            .map(|channel| {
                channel.quantity(&dataset.machine) == feeler_plant::description::Quantity::Position
            })
            .collect();
        let is_read = |c: &crate::dataset::Channel| {
            c.quantity(&dataset.machine) == feeler_plant::description::Quantity::Acceleration
        };
        let is_blind = !dataset.channels.iter().any(is_read);
        let against: Vec<Vec<Option<Against>>> =
            dataset.records.iter().map(|record| against(dataset, record)).collect();
        let sigma = (0..dataset.records.len())
            .map(|r| {
                // Accelerometers keep a prediction on the motion despite noise of the command.
                let wander = if is_blind { wander(dataset, r, reference[r].omega) } else { 0.0 };
                let commanded = if is_blind { commanded_acceleration(dataset, r) } else { 0.0 };
                let accelerations =
                    acceleration_scale(dataset, &scale[r], r, reference[r].omega).max(commanded);
                (0..channels)
                    .map(|c| {
                        if let Some(against) = against[r][c].filter(|_| scale[r][c].is_finite()) {
                            let stretch = against.variation(&dataset.records[r], c);
                            let noise = against.noise(noise[r][c], &noise[r]);
                            return noise.hypot(DISCREPANCY * stretch).hypot(AGREEMENT * scale[r][c]);
                        }
                        let expected = if is_position[c] && reference[r].omega > 0.0 {
                            accelerations / reference[r].omega.powi(2)
                        } else {
                            scale[r][c]
                        };
                        let wander = if is_position[c] { wander } else { 0.0 };
                        noise[r][c].hypot(DISCREPANCY * expected).hypot(wander).max(f64::MIN_POSITIVE)
                    })
                    .collect()
            })
            .collect();
        let looks = (dataset.records.iter().zip(reference))
            .map(|(record, reference)| {
                let omega = is_blind.then_some(reference.omega).filter(|o| *o > 0.0);
                (0..channels).map(|c| looks(record, c, omega)).collect()
            })
            .collect();
        Self { noise, scale, sigma, looks, against, coarse: Coarse::of(dataset) }
    }
}

/// Number of independent samples in channel `c` of a record. `omega` is the natural frequency of the
/// anchoring, rad/s, if only positions correct the prediction.
fn looks(record: &Record, c: usize, omega: Option<f64>) -> f64 {
    let rows = record.len() as f64;
    let per_s = omega.map_or(LOOKS_PER_S, |omega| (LOOKS_PER_RADIAN * omega).min(LOOKS_PER_S));
    (per_s * rows * record.spacing_s).min(record.count(c) as f64 / ROWS_PER_LOOK).max(FEWEST_LOOKS)
}

/// Root mean square acceleration of a record: measured, or from the variation of the position at the
/// frequency of the observer.
fn acceleration_scale(dataset: &Dataset, scale: &[f64], record: usize, omega: f64) -> f64 {
    use feeler_plant::description::Quantity;
    let of = |wanted: Quantity| {
        (0..scale.len())
            .find(|&c| scale[c].is_finite() && dataset.channels[c].quantity(&dataset.machine) == wanted)
    };
    if let Some(c) = of(Quantity::Acceleration) {
        return scale[c];
    }
    let Some(c) = of(Quantity::Position) else { return 0.0 };
    // Second difference over the memory of the observer.
    let series = &dataset.records[record].series[c];
    let span = ((1.0 / (omega * dataset.records[record].spacing_s)).round() as usize).max(1);
    let h = span as f64 * dataset.records[record].spacing_s;
    let n = series.len().saturating_sub(2 * span).max(1);
    let sum: f64 = (0..series.len().saturating_sub(2 * span))
        .map(|k| ((series[k + 2 * span] - 2.0 * series[k + span] + series[k]) / (h * h)).powi(2))
        .sum();
    (sum / n as f64).sqrt()
}

/// Records with their weights, and the indices of those that are fitted.
pub(crate) struct Task<'a> {
    pub(crate) dataset: &'a Dataset,
    pub(crate) weights: Weights,
    pub(crate) fitted: Vec<usize>,
    pub(crate) budget: Budget,
    /// The records as balances of forces, if a balance can show them.
    pub(crate) inverse: Option<Inverse>,
}

/// A fitted model.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub(crate) model: Model,
    pub(crate) theta: Vec<f64>,
    pub(crate) cost: f64,
    /// Standard deviations of `theta`.
    pub(crate) sigma: Vec<f64>,
}

/// The part of a residual that exceeds the quantisation of its reading.
pub(crate) fn beyond(residual: f64, dead_zone: f64) -> f64 {
    residual - residual.clamp(-dead_zone, dead_zone)
}

/// Pseudo-Huber loss (Charbonnier), and the weight of a residual in it.
pub(crate) fn robust(r: f64) -> (f64, f64) {
    let t = (1.0 + (r / ROBUST_SIGMAS).powi(2)).sqrt();
    (2.0 * ROBUST_SIGMAS.powi(2) * (t - 1.0), 1.0 / t)
}

impl Task<'_> {
    /// The anchored prediction of one record; `None` if the model makes no valid machine or its motion is not
    /// finite.
    pub(crate) fn predict(&self, model: &Model, theta: &[f64], record: usize) -> Option<Prediction> {
        let assembly = model.assembly(theta, self.dataset.records[record].engagement)?;
        let prediction =
            Predictor::with(assembly, model.leeway(theta), self.dataset, &self.dataset.records[record])
                .ok()?
                .anchored()
                .ok()?;
        prediction.series.iter().all(|series| series.iter().all(|x| x.is_finite())).then_some(prediction)
    }

    /// Mean robust squared residual per record and channel.
    pub(crate) fn misfits(&self, model: &Model, theta: &[f64], records: &[usize]) -> Option<Vec<Vec<f64>>> {
        records
            .par_iter()
            .map(|&r| {
                let prediction = self.predict(model, theta, r)?;
                Some(self.misfit_of(r, &prediction))
            })
            .collect()
    }

    pub(crate) fn misfit_of(&self, r: usize, prediction: &Prediction) -> Vec<f64> {
        let record = &self.dataset.records[r];
        let loss = |c: usize| {
            let sum: f64 = self.residuals(r, c, prediction).into_iter().map(|x| robust(x).0).sum();
            sum / record.count(c) as f64
        };
        (0..record.series.len()).map(loss).collect()
    }

    /// What one reading of a channel counts in the cost.
    pub(crate) fn share(&self, r: usize, c: usize) -> f64 {
        PIECES / self.dataset.records[r].count(c) as f64
    }

    pub(crate) fn prior_cost(model: &Model, theta: &[f64]) -> f64 {
        let term = |(unknown, theta): (&Unknown, &f64)| {
            unknown.prior.map_or(0.0, |(mean, sigma)| ((theta - mean) / sigma).powi(2))
        };
        model.unknowns.iter().zip(theta).map(term).sum()
    }

    /// Cost over the fitted records: pieces times mean loss, and the priors.
    pub(crate) fn cost(&self, model: &Model, theta: &[f64]) -> f64 {
        self.misfits(model, theta, &self.fitted).map_or(f64::INFINITY, |misfits| {
            PIECES * misfits.iter().flatten().sum::<f64>() + Self::prior_cost(model, theta)
        })
    }

    /// The prediction with unknown `i` shifted slightly, and the shift. `None` if the model is invalid with
    /// either sign of the shift.
    pub(crate) fn moved(
        &self,
        model: &Model,
        theta: &[f64],
        i: usize,
        record: usize,
    ) -> Option<(Prediction, f64)> {
        let difference = model.unknowns[i].difference;
        [difference, -difference].into_iter().find_map(|step| {
            let mut probe = theta.to_vec();
            probe[i] += step;
            Some((self.predict(model, &probe, record)?, step))
        })
    }

    /// Normal equations of one record: `J^T W J`, `J^T W r`. `still` is a direction along which nothing that
    /// is measured changes; empty for none.
    fn normal(
        &self,
        model: &Model,
        theta: &[f64],
        still: &[f64],
        r: usize,
    ) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let n = theta.len();
        let base = self.predict(model, theta, r)?;
        let moved: Vec<Option<(Prediction, f64)>> = (0..n).map(|i| self.moved(model, theta, i, r)).collect();
        let mut a = DMatrix::zeros(n, n);
        let mut b = DVector::zeros(n);
        for c in 0..self.dataset.channels.len() {
            let mut slopes = self.slopes(r, c, &base, &moved);
            without(still, &mut slopes);
            let residuals = self.residuals(r, c, &base);
            let mut weights = self.robust_weights(r, c, &residuals);
            // Within the dead zone a slope has no effect.
            let dead_zone = self.dead_zone(r, c, &base);
            let is_within = |residual: &f64| *residual == 0.0 && dead_zone != 0.0;
            let rows = weights.iter_mut().zip(&residuals).filter(|(_, residual)| is_within(residual));
            rows.for_each(|(weight, _)| *weight = 0.0);
            let factor = self.share(r, c);
            add_curvature(&mut a, factor, &slopes, &weights);
            add_gradient(&mut b, factor, &slopes, &times(&residuals, &weights));
        }
        Some((a, b))
    }

    /// Fits from `start` in at most `steps` steps.
    pub(crate) fn fit(&self, model: &Model, start: &[f64], steps: usize) -> Fitted {
        let scale = self.shared_scale(model, start);
        let begun = self.settled(model, start, self.cost(model, start), scale.as_ref());
        let Fitted { theta, cost, sigma, .. } = self.descend(model, begun, scale.as_ref(), steps);
        let (theta, cost) = self.settled(model, &theta, cost, scale.as_ref());
        Fitted { model: model.clone(), theta, cost, sigma }
    }

    /// A point and its cost, or those with the scale that the believed values ask for where that costs less.
    fn settled(
        &self,
        model: &Model,
        theta: &[f64],
        cost: f64,
        scale: Option<&SharedScale>,
    ) -> (Vec<f64>, f64) {
        let settled = scale.map(|scale| scale.settled(model, theta));
        let settled = settled.map(|settled| (self.cost(model, &settled), settled));
        match settled.filter(|(tried, _)| *tried < cost) {
            Some((tried, settled)) => (settled, tried),
            None => (theta.to_vec(), cost),
        }
    }

    /// The steps of a fit from a point with its cost.
    fn descend(
        &self,
        model: &Model,
        (mut theta, mut cost): (Vec<f64>, f64),
        scale: Option<&SharedScale>,
        steps: usize,
    ) -> Fitted {
        let n = theta.len();
        let mut damping = 1e-3;
        let mut sigma = vec![f64::INFINITY; n];
        for _ in 0..steps {
            if !cost.is_finite() || self.budget.is_over(Stage::Compose) {
                break;
            }
            let still = scale.map_or_else(Vec::new, |scale| scale.direction(model, &theta));
            let parts: Option<Vec<_>> =
                self.fitted.par_iter().map(|&r| self.normal(model, &theta, &still, r)).collect();
            let Some(parts) = parts else { break };
            let mut a = DMatrix::zeros(n, n);
            let mut b = DVector::zeros(n);
            for (pa, pb) in parts {
                a += pa;
                b += pb;
            }
            for (i, unknown) in model.unknowns.iter().enumerate() {
                if let Some((mean, prior)) = unknown.prior {
                    a[(i, i)] += prior.powi(-2);
                    b[i] -= (theta[i] - mean) / prior.powi(2);
                }
            }
            sigma = deviations(&a);
            let mut gained = None;
            for _ in 0..6 {
                let mut damped = a.clone();
                for i in 0..n {
                    damped[(i, i)] += damping * a[(i, i)].max(1e-9) + 1e-9;
                }
                let (low, high) = reach(&model.unknowns, &theta);
                let Some(step) = minimise(&damped, &b, &low, &high) else {
                    damping *= 10.0;
                    continue;
                };
                let probe: Vec<f64> =
                    theta.iter().zip(step.iter()).map(|(theta, step)| theta + step).collect();
                let tried = self.cost(model, &probe);
                if tried < cost {
                    gained = Some(cost - tried);
                    theta = probe;
                    cost = tried;
                    damping = (damping * 0.1).max(LEAST_DAMPING);
                    break;
                }
                damping *= 8.0;
            }
            // If only priors separate two unknowns, the cost has a valley and a damped fit creeps along it.
            // One more step is therefore taken undamped.
            match gained {
                Some(gain) if gain >= CONVERGED + CONVERGED_SHARE * cost => {}
                Some(_) if damping > LEAST_DAMPING => damping = LEAST_DAMPING,
                _ => break,
            }
        }
        Fitted { model: model.clone(), theta, cost, sigma }
    }
}

/// Longest step of one unknown: a factor of e, or its unit.
const LONGEST_STEP: f64 = 1.0;

/// Largest step of each unknown, downward and upward.
pub(crate) fn reach(unknowns: &[Unknown], theta: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let of = |(unknown, theta): (&Unknown, &f64)| {
        let (low, high) = unknown.bounds;
        ((low - theta).clamp(-LONGEST_STEP, 0.0), (high - theta).clamp(0.0, LONGEST_STEP))
    };
    unknowns.iter().zip(theta).map(of).unzip()
}

/// Standard deviations from the normal matrix.
pub(crate) fn deviations(a: &DMatrix<f64>) -> Vec<f64> {
    let n = a.nrows();
    // Unknowns without influence must not spoil the others.
    let scale: Vec<f64> = (0..n).map(|i| a[(i, i)].sqrt().max(1e-9)).collect();
    let scaled =
        DMatrix::from_fn(n, n, |i, j| a[(i, j)] / (scale[i] * scale[j]) + if i == j { 1e-10 } else { 0.0 });
    scaled.try_inverse().map_or_else(
        || vec![f64::INFINITY; n],
        |inverse| (0..n).map(|i| inverse[(i, i)].max(0.0).sqrt() / scale[i]).collect(),
    )
}
