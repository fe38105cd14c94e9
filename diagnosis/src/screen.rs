//! Candidates compared cheaply: a few steps in the parameters of an effect, the other unknowns following linearly.
//!
//! The slopes of the base model are taken once; every trial value of the effect then costs one prediction, and the best shift of the other unknowns follows
//! from the normal equations (variable projection with frozen slopes: Golub and Pereyra, SIAM J. Numerical Analysis 10, 1973; Kaufman, BIT 15, 1975).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use crate::fit::{Fitted, LONGEST_STEP, PIECES, Task, beyond, deviations, robust};
use crate::model::Model;
use crate::predict::Prediction;

/// Trials of a shorter step before a fit is left where it is.
const TRIALS: usize = 4;
/// Gain of the cost in one step below which screening stops.
const SETTLED: f64 = 1.0;

/// A fitted model with its slopes on the fitted records.
pub(crate) struct Linearised<'a> {
    task: &'a Task<'a>,
    base: &'a Fitted,
    /// Per fitted record and channel, row by row the slopes of the prediction in sigmas along every unknown.
    slopes: Vec<Vec<Vec<f64>>>,
    normal: DMatrix<f64>,
    factor: Cholesky<f64, Dyn>,
    /// What the priors pull with at the base.
    pull: DVector<f64>,
}

/// Trial values of an effect, with the other unknowns where they follow to.
struct Trial {
    cost: f64,
    shift: DVector<f64>,
    /// Weighted residuals along the slopes of the other unknowns.
    along: DVector<f64>,
    predictions: Vec<Prediction>,
}

impl<'a> Linearised<'a> {
    /// Takes the slopes of a fitted model; none where it does not predict.
    pub(crate) fn new(task: &'a Task<'a>, base: &'a Fitted) -> Option<Self> {
        let n = base.theta.len();
        let parts: Option<Vec<_>> = task
            .fitted
            .par_iter()
            .map(|&r| {
                let here = task.predict(&base.model, &base.theta, r)?;
                let moved: Vec<Option<(Prediction, f64)>> = (0..n).map(|i| task.moved(&base.model, &base.theta, i, r)).collect();
                let series = &task.dataset.records[r].series;
                let mut normal = DMatrix::zeros(n, n);
                let slopes: Vec<Vec<f64>> = (0..series.len())
                    .map(|c| {
                        let sigma = task.weights.sigma[r][c];
                        let rows = series[c].len();
                        let mut slopes = vec![0.0; rows * n];
                        for (i, moved) in moved.iter().enumerate() {
                            let Some((moved, step)) = moved else { continue };
                            for k in 0..rows {
                                slopes[k * n + i] = (moved.smooth[c][k] - here.smooth[c][k]) / (step * sigma);
                            }
                        }
                        for (k, slope) in slopes.chunks_exact(n).enumerate() {
                            let residual = beyond(series[c][k] - here.smooth[c][k], here.dead_zone[c]) / sigma;
                            let factor = PIECES / rows as f64 * robust(residual).1;
                            for i in 0..n {
                                for j in 0..=i {
                                    normal[(i, j)] += factor * slope[i] * slope[j];
                                }
                            }
                        }
                        slopes
                    })
                    .collect();
                Some((slopes, normal))
            })
            .collect();
        let mut normal = DMatrix::zeros(n, n);
        let mut slopes = Vec::new();
        for (part, a) in parts? {
            normal += a;
            slopes.push(part);
        }
        normal.fill_upper_triangle_with_lower_triangle();
        let mut pull = DVector::zeros(n);
        for (i, unknown) in base.model.unknowns.iter().enumerate() {
            if let Some((mean, prior)) = unknown.prior {
                normal[(i, i)] += prior.powi(-2);
                pull[i] = (base.theta[i] - mean) / prior.powi(2);
            }
            // Unknowns that nothing depends on stay.
            normal[(i, i)] += 1e-9;
        }
        let factor = normal.clone().cholesky()?;
        Some(Self { task, base, slopes, normal, factor, pull })
    }

    /// A few steps from `start`, of which the first unknowns are those of the base.
    pub(crate) fn screen(&self, model: &Model, start: &[f64], steps: usize) -> Option<Fitted> {
        let n = self.base.theta.len();
        let own = start.len() - n;
        let mut theta = start.to_vec();
        let mut here = self.trial(model, &theta)?;
        let mut damping = 1e-2;
        let mut curvature = DMatrix::identity(own, own);
        for _ in 0..steps {
            let Some((a, b)) = self.own_normal(model, &theta, &here) else { break };
            curvature = a;
            let mut gain = 0.0;
            for _ in 0..TRIALS {
                let mut damped = curvature.clone();
                for i in 0..own {
                    damped[(i, i)] += damping * curvature[(i, i)].max(1e-9) + 1e-9;
                }
                let Some(step) = damped.cholesky().map(|factor| factor.solve(&b)) else { break };
                let mut probe = theta.clone();
                for i in 0..own {
                    let (low, high) = model.unknowns[n + i].bounds;
                    probe[n + i] = (theta[n + i] + step[i].clamp(-LONGEST_STEP, LONGEST_STEP)).clamp(low, high);
                }
                if let Some(there) = self.trial(model, &probe)
                    && there.cost < here.cost
                {
                    gain = here.cost - there.cost;
                    (theta, here) = (probe, there);
                    damping *= 0.1;
                    break;
                }
                damping *= 10.0;
            }
            if gain < SETTLED {
                break;
            }
        }
        for (theta, shift) in theta.iter_mut().zip(here.shift.iter()) {
            *theta += shift;
        }
        let sigma = deviations(&self.normal).into_iter().chain(deviations(&curvature)).collect();
        Some(Fitted { model: model.clone(), theta, cost: here.cost, sigma })
    }

    /// The cost at trial values, the other unknowns shifted to where they fit best within their bounds.
    pub(crate) fn cost(&self, model: &Model, theta: &[f64]) -> f64 {
        self.trial(model, theta).map_or(f64::INFINITY, |trial| trial.cost)
    }

    fn trial(&self, model: &Model, theta: &[f64]) -> Option<Trial> {
        let n = self.base.theta.len();
        let parts: Option<Vec<_>> = self
            .task
            .fitted
            .par_iter()
            .zip(&self.slopes)
            .map(|(&r, slopes)| {
                let prediction = self.task.predict(model, theta, r)?;
                let cost = PIECES * self.task.misfit_of(r, &prediction).iter().sum::<f64>();
                let mut along = DVector::zeros(n);
                self.for_rows(r, &prediction, |c, k, residual, factor| {
                    for (sum, slope) in along.iter_mut().zip(&slopes[c][k * n..(k + 1) * n]) {
                        *sum += factor * residual * slope;
                    }
                });
                Some((prediction, cost, along))
            })
            .collect();
        let mut along = -&self.pull;
        let mut cost = Task::prior_cost(&self.base.model, &self.base.theta);
        let mut predictions = Vec::new();
        for (prediction, part, b) in parts? {
            predictions.push(prediction);
            cost += part;
            along += b;
        }
        let mut shift = self.factor.solve(&along);
        for (i, unknown) in self.base.model.unknowns.iter().enumerate() {
            let (low, high) = unknown.bounds;
            let at = self.base.theta[i];
            shift[i] = (at + shift[i].clamp(-LONGEST_STEP, LONGEST_STEP)).clamp(low, high) - at;
        }
        cost += (&self.normal * &shift).dot(&shift) - 2.0 * along.dot(&shift);
        cost.is_finite().then_some(Trial { cost, shift, along, predictions })
    }

    /// Calls `f(channel, row, residual in sigmas, weight)` for every reading of a record.
    fn for_rows(&self, r: usize, prediction: &Prediction, mut f: impl FnMut(usize, usize, f64, f64)) {
        for (c, measured) in self.task.dataset.records[r].series.iter().enumerate() {
            let sigma = self.task.weights.sigma[r][c];
            let factor = PIECES / measured.len() as f64;
            for (k, (m, p)) in measured.iter().zip(&prediction.smooth[c]).enumerate() {
                let residual = beyond(m - p, prediction.dead_zone[c]) / sigma;
                f(c, k, residual, factor * robust(residual).1);
            }
        }
    }

    /// Normal equations of the effect's own parameters, what the other unknowns can take over being projected out.
    fn own_normal(&self, model: &Model, theta: &[f64], here: &Trial) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let n = self.base.theta.len();
        let own = theta.len() - n;
        let parts: Option<Vec<_>> = self
            .task
            .fitted
            .par_iter()
            .zip(self.slopes.par_iter().zip(&here.predictions))
            .map(|(&r, (slopes, prediction))| {
                let moved: Vec<Option<(Prediction, f64)>> = (0..own).map(|i| self.task.moved(model, theta, n + i, r)).collect();
                let mut a = DMatrix::zeros(own, own);
                let mut mixed = DMatrix::zeros(n, own);
                let mut b = DVector::zeros(own);
                let mut slope = vec![0.0; own];
                self.for_rows(r, prediction, |c, k, residual, factor| {
                    let sigma = self.task.weights.sigma[r][c];
                    for (slope, moved) in slope.iter_mut().zip(&moved) {
                        *slope = moved.as_ref().map_or(0.0, |(m, step)| (m.smooth[c][k] - prediction.smooth[c][k]) / (step * sigma));
                    }
                    for i in 0..own {
                        let s = factor * slope[i];
                        if s != 0.0 {
                            b[i] += s * residual;
                            for j in 0..own {
                                a[(i, j)] += s * slope[j];
                            }
                            for (sum, other) in mixed.column_mut(i).iter_mut().zip(&slopes[c][k * n..(k + 1) * n]) {
                                *sum += s * other;
                            }
                        }
                    }
                });
                Some((a, mixed, b))
            })
            .collect();
        let mut a = DMatrix::zeros(own, own);
        let mut mixed = DMatrix::zeros(n, own);
        let mut b = DVector::zeros(own);
        for (pa, pm, pb) in parts? {
            a += pa;
            mixed += pm;
            b += pb;
        }
        let taken = self.factor.solve(&mixed);
        Some((a - mixed.transpose() * &taken, b - taken.transpose() * &here.along))
    }
}
