//! Scales of residuals: noise, errors that no model is expected to explain, and the number of independent
//! samples.

use feeler_plant::description::Quantity;

use crate::dataset::{Channel, Dataset, Record};
use crate::fit::coarse::Coarse;
use crate::fit::elongation::{Against, against};
use crate::fit::wander::{commanded_acceleration, wander};
use crate::predict::Prediction;

/// Share of a channel's variation that no model is expected to explain.
const DISCREPANCY: f64 = 0.01;
/// Relative difference between the scales of two sensors on a rigid joint.
const AGREEMENT: f64 = 1e-4;
/// Smallest scale of a channel in one experiment, as a share of its variation over all experiments.
const SMALLEST_SCALE: f64 = 0.1;
/// Independent samples per channel and second of motion: errors of a model are correlated over about a tenth
/// of a second.
const LOOKS_PER_S: f64 = 8.0;
/// Independent samples per radian of the observer's frequency if only positions correct a prediction. Errors
/// are then correlated over the observer's memory.
const LOOKS_PER_RADIAN: f64 = 0.2;
/// Smallest number of independent samples of an experiment, and of rows per sample.
const FEWEST_LOOKS: f64 = 4.0;
const ROWS_PER_LOOK: f64 = 10.0;

/// Scales of the residuals, per record and channel.
#[derive(Clone, Debug)]
pub(crate) struct Weights {
    /// Standard deviation of noise.
    pub(crate) noise: Vec<Vec<f64>>,
    /// Root mean square of the variation.
    pub(crate) scale: Vec<Vec<f64>>,
    /// Divisor of a residual.
    pub(crate) sigma: Vec<Vec<f64>>,
    /// Number of independent samples.
    pub(crate) looks: Vec<Vec<f64>>,
    /// The reference channel from which a channel is subtracted; `None` for a channel that is compared by
    /// itself.
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
        // A channel that never changes carries no information, even if its prediction is wrong.
        let scale =
            |own: f64, pooled: f64| if own > 0.0 { own.max(SMALLEST_SCALE * pooled) } else { f64::INFINITY };
        let scale: Vec<Vec<f64>> = own
            .iter()
            .map(|own| own.iter().zip(&pooled).map(|(&own, &pooled)| scale(own, pooled)).collect())
            .collect();
        let noise: Vec<Vec<f64>> =
            dataset.records.iter().map(|_| dataset.channels.iter().map(Channel::sigma).collect()).collect();
        // The anchored prediction of a position differs from its reading by the effect of an acceleration
        // error within the memory of the observer only.
        let is_position: Vec<bool> = dataset
            .channels
            .iter()
            .map(|channel| channel.quantity(&dataset.machine) == Quantity::Position)
            .collect();
        let is_read = |c: &Channel| c.quantity(&dataset.machine) == Quantity::Acceleration;
        let is_blind = !dataset.channels.iter().any(is_read);
        let against = against(dataset);
        let sigma = (0..dataset.records.len())
            .map(|r| {
                // Accelerometers keep a prediction on the motion, even if the command is noisy.
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
/// observer correction, rad/s, if only positions correct the prediction.
fn looks(record: &Record, c: usize, omega: Option<f64>) -> f64 {
    let rows = record.len() as f64;
    let per_s = omega.map_or(LOOKS_PER_S, |omega| (LOOKS_PER_RADIAN * omega).min(LOOKS_PER_S));
    (per_s * rows * record.spacing_s).min(record.count(c) as f64 / ROWS_PER_LOOK).max(FEWEST_LOOKS)
}

/// Root mean square acceleration of a record: measured, or from the variation of the position at the
/// frequency of the observer.
fn acceleration_scale(dataset: &Dataset, scale: &[f64], record: usize, omega: f64) -> f64 {
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

impl Weights {
    /// Noise of the series with which a channel of a record is compared, from the noise of every channel.
    pub(crate) fn noise_of(&self, r: usize, c: usize, noise: &[f64]) -> f64 {
        self.against[r][c].map_or(noise[c], |against| against.noise(noise[c], noise))
    }

    /// Whether a channel is compared as the elongation of a joint in every record in which it is used.
    pub(crate) fn is_elongation(&self, c: usize) -> bool {
        let mut counted = self.against.iter().zip(&self.sigma).filter(|(_, sigma)| sigma[c].is_finite());
        counted.clone().next().is_some() && counted.all(|(against, _)| against[c].is_some())
    }
}
