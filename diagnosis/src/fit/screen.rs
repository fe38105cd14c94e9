//! Compares candidates cheaply: a few steps in the parameters of an effect, while the other unknowns are
//! linearised.
//!
//! The slopes of the base model are computed once. Every trial value of the effect then costs one prediction.
//! The best change of the other unknowns follows from the normal equations. This is variable projection with
//! fixed slopes (Golub and Pereyra, SIAM J. Numerical Analysis 10, 1973; Kaufman, BIT 15, 1975).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::fit::bounded::minimise;
use crate::fit::curvature::{add_curvature, add_gradient, add_mixed, along, times};
use crate::fit::least_squares::{Fitted, Task, beyond, deviations, reach, robust};
use crate::fit::model::Model;
use crate::predict::Prediction;

/// Number of shorter steps that are tried before screening stops.
const TRIALS: usize = 4;
/// Gain of the cost in one step below which screening stops, absolute and as a share of the cost.
const SETTLED: f64 = 1.0;
const SETTLED_SHARE: f64 = 1e-3;
/// Bound on a fit's further gain, as a multiple of its last gain: converging steps halve their gain.
const STILL_TO_GAIN: f64 = 2.0;

/// A fitted model with its slopes on the fitted records.
pub(crate) struct Linearised<'a> {
    task: &'a Task<'a>,
    base: &'a Fitted,
    /// Per fitted record and channel, the slopes of the prediction in sigmas along every unknown.
    slopes: Vec<Vec<Vec<Vec<f64>>>>,
    /// Curvature of the cost along the other unknowns: with the robust weights of the base, and with equal
    /// weights.
    normal: DMatrix<f64>,
    plain: DMatrix<f64>,
    /// Gradient of the priors at the base.
    pull: DVector<f64>,
}

/// A fit of a few steps, with a bound on the cost that further steps may reach.
pub(crate) struct Screened {
    pub(crate) fitted: Fitted,
    pub(crate) bound: f64,
}

/// A fit under way, after some steps.
pub(crate) struct Screening {
    model: Model,
    theta: Vec<f64>,
    here: Trial,
    damping: f64,
    curvature: DMatrix<f64>,
    /// Gain of the last step; infinite before the first.
    gain: f64,
}

impl Screening {
    /// The cost reached, and a bound on the cost that further steps may reach.
    pub(crate) fn costs(&self) -> [f64; 2] {
        [self.here.cost, self.here.cost - STILL_TO_GAIN * self.gain]
    }
}

/// Trial values of an effect, with the other unknowns shifted to fit.
pub(crate) struct Trial {
    pub(crate) cost: f64,
    shift: DVector<f64>,
    /// Shift of the other unknowns at which the robust weights were computed.
    weighed_at: DVector<f64>,
    /// The other unknowns that are free; the rest are at their bounds.
    free: Vec<usize>,
    predictions: Vec<Prediction>,
}

impl<'a> Linearised<'a> {
    /// Computes the slopes of a fitted model; `None` if it has no prediction.
    pub(crate) fn new(task: &'a Task<'a>, base: &'a Fitted) -> Option<Self> {
        let n = base.theta.len();
        let parts: Option<Vec<_>> = task
            .fitted
            .par_iter()
            .map(|&r| {
                let here = task.predict(&base.model, &base.theta, r)?;
                let moved: Vec<Option<(Prediction, f64)>> =
                    (0..n).map(|i| task.moved(&base.model, &base.theta, i, r)).collect();
                let record = &task.dataset.records[r];
                let (mut normal, mut plain) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
                let slopes: Vec<Vec<Vec<f64>>> = (0..record.series.len())
                    .map(|c| {
                        let slopes = task.slopes(r, c, &here, &moved);
                        let weights = task.robust_weights(r, c, &task.residuals(r, c, &here));
                        let mut alike = vec![1.0; weights.len()];
                        task.blank(r, c, &mut alike);
                        add_curvature(&mut normal, task.share(r, c), &slopes, &weights);
                        add_curvature(&mut plain, task.share(r, c), &slopes, &alike);
                        slopes
                    })
                    .collect();
                Some((slopes, normal, plain))
            })
            .collect();
        let (mut normal, mut plain) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        let mut slopes = Vec::new();
        for (part, weighted, alike) in parts? {
            normal += weighted;
            plain += alike;
            slopes.push(part);
        }
        let mut pull = DVector::zeros(n);
        for (i, unknown) in base.model.unknowns.iter().enumerate() {
            for curvature in [&mut normal, &mut plain] {
                // A small term keeps the matrix regular for unknowns without influence.
                curvature[(i, i)] += unknown.prior.map_or(0.0, |(_, prior)| prior.powi(-2)) + 1e-9;
            }
            pull[i] = unknown.prior.map_or(0.0, |(mean, prior)| (base.theta[i] - mean) / prior.powi(2));
        }
        Some(Self { task, base, slopes, normal, plain, pull })
    }

    /// Begins at a start, which may have been tried already. Its first unknowns are those of the base.
    pub(crate) fn begin(&self, model: Model, theta: Vec<f64>, tried: Option<Trial>) -> Option<Screening> {
        let own = theta.len() - self.base.theta.len();
        let here = tried.or_else(|| self.trial(&model, &theta))?;
        let curvature = DMatrix::identity(own, own);
        Some(Screening { model, theta, here, damping: 1e-2, curvature, gain: f64::INFINITY })
    }

    /// Takes a few steps, unless the last one gained next to nothing.
    pub(crate) fn advance(&self, screening: &mut Screening, steps: usize) {
        let n = self.base.theta.len();
        let Screening { model, theta, here, damping, curvature, gain } = screening;
        for _ in 0..steps {
            if *gain < SETTLED + SETTLED_SHARE * here.cost {
                break;
            }
            let Some((a, b)) = self.own_normal(model, theta, here) else {
                *gain = if gain.is_finite() { *gain } else { 0.0 };
                break;
            };
            (*curvature, *gain) = (a, 0.0);
            for _ in 0..TRIALS {
                let mut damped = curvature.clone();
                for i in 0..b.len() {
                    damped[(i, i)] += *damping * curvature[(i, i)].max(1e-9) + 1e-9;
                }
                let (low, high) = reach(&model.unknowns[n..], &theta[n..]);
                let Some(step) = minimise(&damped, &b, &low, &high) else { break };
                let mut probe = theta.clone();
                for (theta, step) in probe[n..].iter_mut().zip(step.iter()) {
                    *theta += step;
                }
                if let Some(there) = self.trial(model, &probe)
                    && there.cost < here.cost
                {
                    *gain = here.cost - there.cost;
                    (*theta, *here) = (probe, there);
                    *damping *= 0.1;
                    break;
                }
                *damping *= 10.0;
            }
        }
    }

    /// The fit that a screening has reached.
    pub(crate) fn end(&self, screening: Screening) -> Screened {
        let [cost, bound] = screening.costs();
        let Screening { model, mut theta, here, curvature, .. } = screening;
        for (theta, shift) in theta.iter_mut().zip(here.shift.iter()) {
            *theta += shift;
        }
        let sigma = deviations(&self.normal).into_iter().chain(deviations(&curvature)).collect();
        Screened { fitted: Fitted { model, theta, cost, sigma }, bound }
    }

    /// Trial values, with the other unknowns at their best fit within their bounds.
    pub(crate) fn trial(&self, model: &Model, theta: &[f64]) -> Option<Trial> {
        let n = self.base.theta.len();
        let predictions: Option<Vec<Prediction>> =
            self.task.fitted.par_iter().map(|&r| self.task.predict(model, theta, r)).collect();
        let predictions = predictions?;
        let (mut low, mut high) = reach(&self.base.model.unknowns, &self.base.theta);
        for i in (0..n).filter(|&i| model.is_idle(i)) {
            (low[i], high[i]) = (0.0, 0.0);
        }
        // Far from the best fit, the robust loss hardly depends on the distance. Plain least squares
        // therefore comes first.
        let still = DVector::zeros(n);
        let [here, alike] = self.along(&predictions, &still);
        let near = minimise(&self.plain, &(alike.1 - &self.pull), &low, &high)?;
        let [there, _] = self.along(&predictions, &near);
        let prior = |shift: &DVector<f64>| {
            let moved: Vec<f64> =
                self.base.theta.iter().zip(shift.iter()).map(|(theta, shift)| theta + shift).collect();
            Task::prior_cost(&self.base.model, &moved)
        };
        let (from_still, from_near) = (here.0 + prior(&still), there.0 + prior(&near));
        let (start, cost, along) =
            if from_near < from_still { (near, from_near, there.1) } else { (still, from_still, here.1) };
        let stiff = self
            .base
            .model
            .unknowns
            .iter()
            .map(|unknown| unknown.prior.map_or(0.0, |(_, prior)| prior.powi(-2)));
        let along = along - &self.pull - DVector::from_iterator(n, stiff).component_mul(&start);
        let [low, high] = [low, high].map(|bound| {
            bound.iter().zip(start.iter()).map(|(bound, start)| bound - start).collect::<Vec<f64>>()
        });
        let step = minimise(&self.normal, &along, &low, &high)?;
        let free = (0..n).filter(|&i| step[i] > low[i] && step[i] < high[i]).collect();
        let cost = cost + (&self.normal * &step).dot(&step) - 2.0 * along.dot(&step);
        let shift = &start + step;
        cost.is_finite().then_some(Trial { cost, shift, weighed_at: start, free, predictions })
    }

    /// Cost without priors at a shift of the other unknowns, and its gradient along their slopes. The first
    /// gradient has robust weights, the second equal ones.
    fn along(&self, predictions: &[Prediction], shift: &DVector<f64>) -> [(f64, DVector<f64>); 2] {
        let n = self.base.theta.len();
        let parts: Vec<(f64, DVector<f64>, DVector<f64>)> =
            (self.task.fitted.par_iter().zip(self.slopes.par_iter().zip(predictions)))
                .map(|(&r, (slopes, prediction))| {
                    let (mut cost, mut weighted, mut alike) = (0.0, DVector::zeros(n), DVector::zeros(n));
                    for (c, slopes) in slopes.iter().enumerate() {
                        let Some(residuals) = self.residuals(r, c, slopes, prediction, shift) else {
                            continue;
                        };
                        let factor = self.task.share(r, c);
                        let mut losses = 0.0;
                        let weigh = |&residual: &f64| {
                            let (loss, weight) = robust(residual);
                            losses += loss;
                            residual * weight
                        };
                        let weighed: Vec<f64> = residuals.iter().map(weigh).collect();
                        cost += factor * losses;
                        add_gradient(&mut weighted, factor, slopes, &weighed);
                        add_gradient(&mut alike, factor, slopes, &residuals);
                    }
                    (cost, weighted, alike)
                })
                .collect();
        let mut cost = 0.0;
        let (mut weighted, mut alike) = (DVector::zeros(n), DVector::zeros(n));
        for (part, a, b) in parts {
            cost += part;
            weighted += a;
            alike += b;
        }
        [(cost, weighted), (cost, alike)]
    }

    /// Residuals of a channel in sigmas at a shift of the other unknowns, zero in rows without a reading;
    /// `None` if the channel never changes.
    fn residuals(
        &self,
        r: usize,
        c: usize,
        slopes: &[Vec<f64>],
        prediction: &Prediction,
        shift: &DVector<f64>,
    ) -> Option<Vec<f64>> {
        let sigma = self.task.weights.sigma[r][c];
        if sigma.is_infinite() {
            return None;
        }
        let mut residuals = self.task.departures(r, c, prediction);
        let dead_zone = self.task.dead_zone(r, c, prediction);
        let moved = along(slopes, shift, residuals.len());
        for (residual, moved) in residuals.iter_mut().zip(&moved) {
            *residual = beyond(*residual - sigma * moved, dead_zone) / sigma;
        }
        self.task.blank(r, c, &mut residuals);
        Some(residuals)
    }

    /// Normal equations of the effect's own parameters, after projecting out the part that the other unknowns
    /// can explain.
    fn own_normal(&self, model: &Model, theta: &[f64], here: &Trial) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let n = self.base.theta.len();
        let own = theta.len() - n;
        let parts: Option<Vec<_>> = self
            .task
            .fitted
            .par_iter()
            .zip(self.slopes.par_iter().zip(&here.predictions))
            .map(|(&r, (others, prediction))| {
                let moved: Vec<Option<(Prediction, f64)>> =
                    (0..own).map(|i| self.task.moved(model, theta, n + i, r)).collect();
                let mut a = DMatrix::zeros(own, own);
                let mut mixed = DMatrix::zeros(n, own);
                let mut b = DVector::zeros(own);
                for (c, others) in others.iter().enumerate() {
                    let Some(residuals) = self.residuals(r, c, others, prediction, &here.weighed_at) else {
                        continue;
                    };
                    let slopes = self.task.slopes(r, c, prediction, &moved);
                    let factor = self.task.share(r, c);
                    let weights = self.task.robust_weights(r, c, &residuals);
                    add_curvature(&mut a, factor, &slopes, &weights);
                    add_mixed(&mut mixed, factor, others, &slopes, &weights);
                    add_gradient(&mut b, factor, &slopes, &times(&residuals, &weights));
                }
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
        let slope = b - mixed.transpose() * (&here.shift - &here.weighed_at);
        let following = mixed.select_rows(&here.free);
        let taken =
            self.normal.select_rows(&here.free).select_columns(&here.free).cholesky()?.solve(&following);
        Some((a - following.transpose() * &taken, slope))
    }
}
