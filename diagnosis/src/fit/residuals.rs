//! Residuals of a prediction, and the common scale of all forces.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::fit::least_squares::{Task, beyond, robust};
use crate::fit::model::Model;
use crate::fit::shared_scale::SharedScale;
use crate::predict::Prediction;

/// Squared change of the prediction, in sigmas, above which the records determine the scale better than the
/// believed values. The scale changes by one standard deviation of its prior.
const KNOWN: f64 = 1.0;

impl Task<'_> {
    /// Name of the series with which a channel is compared.
    pub(crate) fn weighed_as(&self, c: usize) -> String {
        let column = |c: usize| &self.dataset.channels[c].column;
        let against = self.weights.against.iter().find_map(|against| against[c]);
        match against.filter(|_| self.weights.is_elongation(c)) {
            Some(against) => format!("`{}` less `{}`", column(c), column(against.channel)),
            None => format!("`{}`", column(c)),
        }
    }

    /// Half the quantisation step of the compared series; zero for a difference. In a difference of two
    /// moving readings, rounding changes in every row: it acts as noise, and averaging resolves less than a
    /// step.
    pub(crate) fn dead_zone(&self, r: usize, c: usize, prediction: &Prediction) -> f64 {
        if self.weights.against[r][c].is_some() { 0.0 } else { prediction.dead_zone[c] }
    }

    /// The smooth prediction of the series with which a channel is compared.
    fn smooth<'p>(&self, r: usize, c: usize, prediction: &'p Prediction) -> Cow<'p, [f64]> {
        let smooth = &prediction.smooth;
        self.weights.against[r][c].map_or(Cow::Borrowed(&smooth[c][..]), |against| {
            Cow::Owned(against.less(&smooth[c], &smooth[against.channel]))
        })
    }

    /// Sets rows without a reading to zero.
    pub(crate) fn blank(&self, r: usize, c: usize, values: &mut [f64]) {
        let record = &self.dataset.records[r];
        match self.weights.against[r][c] {
            Some(against) => against.blank(record, c, values),
            None => record.blank(c, values),
        }
    }

    /// Residuals of a channel in signal units, before the dead zone of an encoder step.
    pub(crate) fn departures(&self, r: usize, c: usize, prediction: &Prediction) -> Vec<f64> {
        let record = &self.dataset.records[r];
        let less = |(measured, predicted): (&f64, &f64)| measured - predicted;
        let own: Vec<f64> = record.series[c].iter().zip(&prediction.smooth[c]).map(less).collect();
        let Some(against) = self.weights.against[r][c] else { return own };
        let other = record.series[against.channel].iter().zip(&prediction.smooth[against.channel]);
        let mut departures = against.less(&own, &other.map(less).collect::<Vec<f64>>());
        against.centre(record, c, &mut departures);
        departures
    }

    /// Residuals of a channel in sigmas; zero in rows without a reading.
    pub(crate) fn residuals(&self, r: usize, c: usize, prediction: &Prediction) -> Vec<f64> {
        let (sigma, dead_zone) = (self.weights.sigma[r][c], self.dead_zone(r, c, prediction));
        let mut residuals = self.departures(r, c, prediction);
        for residual in &mut residuals {
            *residual = beyond(*residual, dead_zone) / sigma;
        }
        self.blank(r, c, &mut residuals);
        residuals
    }

    /// Robust weights of the residuals of a channel; zero in rows without a reading.
    pub(crate) fn robust_weights(&self, r: usize, c: usize, residuals: &[f64]) -> Vec<f64> {
        let mut weights: Vec<f64> = residuals.iter().map(|&residual| robust(residual).1).collect();
        self.blank(r, c, &mut weights);
        weights
    }

    /// Robust weights that are zero also within the dead zone, where a slope has no effect.
    pub(crate) fn weights_beyond(
        &self,
        r: usize,
        c: usize,
        prediction: &Prediction,
        residuals: &[f64],
    ) -> Vec<f64> {
        let mut weights = self.robust_weights(r, c, residuals);
        if self.dead_zone(r, c, prediction) != 0.0 {
            let within = weights.iter_mut().zip(residuals).filter(|(_, residual)| **residual == 0.0);
            within.for_each(|(weight, _)| *weight = 0.0);
        }
        weights
    }

    /// Slopes of channel `c` in sigmas, by unknown, from shifted predictions. The slope is zero if an unknown
    /// cannot be shifted.
    pub(crate) fn slopes(
        &self,
        r: usize,
        c: usize,
        base: &Prediction,
        moved: &[Option<(Prediction, f64)>],
    ) -> Vec<Vec<f64>> {
        let (base, sigma) = (self.smooth(r, c, base), self.weights.sigma[r][c]);
        let of = |moved: &Option<(Prediction, f64)>| {
            let Some((moved, step)) = moved else { return vec![0.0; base.len()] };
            let moved = self.smooth(r, c, moved);
            let mut slope: Vec<f64> =
                moved.iter().zip(base.iter()).map(|(m, b)| (m - b) / (step * sigma)).collect();
            if let Some(against) = self.weights.against[r][c] {
                against.centre(&self.dataset.records[r], c, &mut slope);
            }
            slope
        };
        moved.iter().map(of).collect()
    }

    /// The scale that all forces of a model share, if the fitted records determine it less well than the
    /// believed values. `None` also if the model has no prediction.
    pub(crate) fn shared_scale(&self, model: &Model, theta: &[f64]) -> Option<SharedScale> {
        let scale = SharedScale::of(model, self.dataset)?;
        let (_, sigma) = scale.believed(model, theta)?;
        let larger = scale.moved(model, theta, sigma);
        let change = |&r: &usize| {
            let here = self.predict(model, theta, r)?;
            let moved = [Some((self.predict(model, &larger, r)?, 1.0))];
            let of = |c: usize| {
                let mut changes = self.slopes(r, c, &here, &moved).swap_remove(0);
                self.blank(r, c, &mut changes);
                self.share(r, c) * changes.iter().map(|change| change * change).sum::<f64>()
            };
            Some((0..self.dataset.channels.len()).map(of).sum::<f64>())
        };
        let changes: Option<Vec<f64>> = self.fitted.par_iter().map(change).collect();
        (changes?.iter().sum::<f64>() < KNOWN).then_some(scale)
    }
}
