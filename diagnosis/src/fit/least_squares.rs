//! Fits unknowns to records by the Levenberg-Marquardt method, with bounds, priors and a robust loss.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::budget::{Budget, Stage};
use crate::dataset::Dataset;
use crate::fit::bounded::minimise;
use crate::fit::curvature::{add_curvature, add_gradient, times};
use crate::fit::model::Model;
use crate::fit::shared_scale::{SharedScale, without};
use crate::fit::unknown::Unknown;
use crate::fit::weights::Weights;
use crate::inverse::Inverse;
use crate::predict::{Prediction, Predictor};

/// Number of independent samples of one channel in one experiment. There are many more readings, but a model
/// error persists over whole stretches of motion.
pub(crate) const PIECES: f64 = 100.0;
/// Residuals beyond this many sigmas enter the cost linearly.
const ROBUST_SIGMAS: f64 = 8.0;
/// Smallest damping of a step.
const LEAST_DAMPING: f64 = 1e-9;
/// A fit has converged if a step reduces the cost by less than this: a hundredth of the cost of one unknown.
const CONVERGED: f64 = 0.02;
/// Relative gain of the cost below which a fit has converged. The gains that distinguish models are far
/// larger.
const CONVERGED_SHARE: f64 = 1e-5;

/// Records with their weights, and the indices of those that are fitted.
pub(crate) struct Task<'a> {
    pub(crate) dataset: &'a Dataset,
    pub(crate) weights: Weights,
    pub(crate) fitted: Vec<usize>,
    pub(crate) budget: Budget,
    /// The records as balances of forces, if a balance applies to this machine.
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

/// A point of a fit, with its predictions of the fitted records.
struct Point {
    theta: Vec<f64>,
    cost: f64,
    predicted: Vec<Prediction>,
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
    /// The anchored prediction of one record; `None` if the model is not a valid machine or its motion is not
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

    /// Weight of one reading of a channel in the cost.
    pub(crate) fn share(&self, r: usize, c: usize) -> f64 {
        PIECES / self.dataset.records[r].count(c) as f64
    }

    pub(crate) fn prior_cost(model: &Model, theta: &[f64]) -> f64 {
        let term = |(unknown, theta): (&Unknown, &f64)| {
            unknown.prior.map_or(0.0, |(mean, sigma)| ((theta - mean) / sigma).powi(2))
        };
        model.unknowns.iter().zip(theta).map(term).sum()
    }

    /// Cost over the fitted records: [`PIECES`] times the mean loss of each channel, plus the priors.
    pub(crate) fn cost(&self, model: &Model, theta: &[f64]) -> f64 {
        self.reached(model, theta.to_vec()).map_or(f64::INFINITY, |point| point.cost)
    }

    /// A point with its cost and predictions; `None` if a record has no prediction.
    fn reached(&self, model: &Model, theta: Vec<f64>) -> Option<Point> {
        let of = |&r: &usize| {
            let prediction = self.predict(model, &theta, r)?;
            Some((self.misfit_of(r, &prediction), prediction))
        };
        let found: Option<Vec<(Vec<f64>, Prediction)>> = self.fitted.par_iter().map(of).collect();
        let (misfits, predicted): (Vec<Vec<f64>>, Vec<Prediction>) = found?.into_iter().unzip();
        let cost = PIECES * misfits.iter().flatten().sum::<f64>() + Self::prior_cost(model, &theta);
        Some(Point { theta, cost, predicted })
    }

    /// The prediction with unknown `i` shifted slightly, and the shift. `None` if the unknown has no
    /// influence, or if the model is invalid with either sign of the shift.
    pub(crate) fn moved(
        &self,
        model: &Model,
        theta: &[f64],
        i: usize,
        record: usize,
    ) -> Option<(Prediction, f64)> {
        if model.is_idle(i) {
            return None;
        }
        let difference = model.unknowns[i].difference;
        [difference, -difference].into_iter().find_map(|step| {
            let mut probe = theta.to_vec();
            probe[i] += step;
            Some((self.predict(model, &probe, record)?, step))
        })
    }

    /// Normal equations of one record, predicted as `base` at a point: `J^T W J`, `J^T W r`. `still` is a
    /// direction in the unknowns that changes no measured signal; empty if there is none. `None` also if the
    /// time is over.
    fn normal(
        &self,
        model: &Model,
        theta: &[f64],
        still: &[f64],
        (r, base): (usize, &Prediction),
    ) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let n = theta.len();
        // A step predicts once for each unknown. If predictions are slow, a step that begins in time would
        // end long after the budget.
        let is_in_time = || !self.budget.is_over(Stage::Compose);
        let moved: Option<Vec<Option<(Prediction, f64)>>> =
            (0..n).map(|i| is_in_time().then(|| self.moved(model, theta, i, r))).collect();
        let moved = moved?;
        let mut a = DMatrix::zeros(n, n);
        let mut b = DVector::zeros(n);
        for c in 0..self.dataset.channels.len() {
            let mut slopes = self.slopes(r, c, base, &moved);
            without(still, &mut slopes);
            let residuals = self.residuals(r, c, base);
            let weights = self.weights_beyond(r, c, base, &residuals);
            let factor = self.share(r, c);
            add_curvature(&mut a, factor, &slopes, &weights);
            add_gradient(&mut b, factor, &slopes, &times(&residuals, &weights));
        }
        Some((a, b))
    }

    /// Fits from `start` in at most `steps` steps.
    pub(crate) fn fit(&self, model: &Model, start: &[f64], steps: usize) -> Fitted {
        let scale = self.shared_scale(model, start);
        let sigma = vec![f64::INFINITY; start.len()];
        let Some(begun) = self.reached(model, start.to_vec()) else {
            return Fitted { model: model.clone(), theta: start.to_vec(), cost: f64::INFINITY, sigma };
        };
        let begun = self.settled(model, begun, scale.as_ref());
        let (ended, sigma) = self.descend(model, begun, scale.as_ref(), steps);
        let Point { theta, cost, .. } = self.settled(model, ended, scale.as_ref());
        Fitted { model: model.clone(), theta, cost, sigma }
    }

    /// A point; or that point with the scale that the believed values prefer, if it costs less.
    fn settled(&self, model: &Model, point: Point, scale: Option<&SharedScale>) -> Point {
        let settled = scale.and_then(|scale| self.reached(model, scale.settled(model, &point.theta)));
        settled.filter(|settled| settled.cost < point.cost).unwrap_or(point)
    }

    /// The iterations of a fit from a point, and the standard deviations at its end.
    fn descend(
        &self,
        model: &Model,
        mut here: Point,
        scale: Option<&SharedScale>,
        steps: usize,
    ) -> (Point, Vec<f64>) {
        let n = here.theta.len();
        let mut damping = 1e-3;
        let mut sigma = vec![f64::INFINITY; n];
        for _ in 0..steps {
            if !here.cost.is_finite() || self.budget.is_over(Stage::Compose) {
                break;
            }
            let theta = &here.theta;
            let still = scale.map_or_else(Vec::new, |scale| scale.direction(model, theta));
            let records = self.fitted.par_iter().copied().zip(&here.predicted);
            let parts: Option<Vec<_>> =
                records.map(|record| self.normal(model, theta, &still, record)).collect();
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
                let (low, high) = reach(&model.unknowns, theta);
                let Some(step) = minimise(&damped, &b, &low, &high) else {
                    damping *= 10.0;
                    continue;
                };
                let probe = theta.iter().zip(step.iter()).map(|(theta, step)| theta + step).collect();
                let tried = self.reached(model, probe);
                if let Some(tried) = tried.filter(|tried| tried.cost < here.cost) {
                    gained = Some(here.cost - tried.cost);
                    here = tried;
                    damping = (damping * 0.1).max(LEAST_DAMPING);
                    break;
                }
                damping *= 8.0;
            }
            // If only priors separate two unknowns, the cost has a narrow valley along which a damped fit
            // advances slowly. One more step is therefore taken without damping.
            match gained {
                Some(gain) if gain >= CONVERGED + CONVERGED_SHARE * here.cost => {}
                Some(_) if damping > LEAST_DAMPING => damping = LEAST_DAMPING,
                _ => break,
            }
        }
        (here, sigma)
    }
}

/// Longest step of one unknown: a factor of e, or its unit for a linear unknown.
const LONGEST_STEP: f64 = 1.0;

/// Largest downward and upward step of each unknown.
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
    // Scaling keeps unknowns without influence from spoiling the inversion.
    let scale: Vec<f64> = (0..n).map(|i| a[(i, i)].sqrt().max(1e-9)).collect();
    let scaled =
        DMatrix::from_fn(n, n, |i, j| a[(i, j)] / (scale[i] * scale[j]) + if i == j { 1e-10 } else { 0.0 });
    scaled.try_inverse().map_or_else(
        || vec![f64::INFINITY; n],
        |inverse| (0..n).map(|i| inverse[(i, i)].max(0.0).sqrt() / scale[i]).collect(),
    )
}
