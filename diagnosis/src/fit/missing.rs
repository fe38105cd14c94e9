//! The force that a fitted machine lacks along a record.

use std::f64::consts::TAU;

use feeler_plant::description::Quantity;

use crate::chance::Chance;
use crate::dataset::Dataset;
use crate::fit::least_squares::Task;
use crate::fit::scored::Scored;
use crate::predict::Prediction;

/// Mass that moves with the first drive.
pub(crate) fn moving_mass(dataset: &Dataset, scored: &Scored) -> f64 {
    let Some(assembly) = scored.fitted.model.assembly(&scored.fitted.theta, None) else { return 1.0 };
    let node = dataset.drives.first().map_or(1, |driven| assembly.drives[driven.drive].on);
    assembly.rigid_mass_kg(node)
}

/// Missing acceleration at each row: the mean residual of the accelerometers. Without any, it follows from
/// the position's residual by the observer's error dynamics.
pub(crate) fn missing_acceleration(dataset: &Dataset, record: usize, prediction: &Prediction) -> Vec<f64> {
    let of = |wanted: Quantity| -> Vec<usize> {
        (0..dataset.channels.len())
            .filter(|&c| {
                dataset.channels[c].quantity(&dataset.machine) == wanted && !dataset.records[record].silent[c]
            })
            .collect()
    };
    let accelerations = of(Quantity::Acceleration);
    let rows = dataset.records[record].len();
    let residual = |c: usize| dataset.records[record].residual(c, &prediction.series[c]);
    if accelerations.is_empty() {
        return match of(Quantity::Position).first() {
            Some(&c) => forcing(&residual(c), prediction.omega, dataset.records[record].spacing_s),
            None => vec![0.0; rows],
        };
    }
    let residuals: Vec<Vec<f64>> = accelerations.iter().map(|&c| residual(c)).collect();
    (0..rows)
        .map(|k| residuals.iter().map(|residual| residual[k]).sum::<f64>() / residuals.len() as f64)
        .collect()
}

/// Root mean square of the missing acceleration that sensor noise alone suggests, encoder steps included.
pub(crate) fn noise_acceleration(task: &Task<'_>, record: usize, omega: f64) -> f64 {
    let dataset = task.dataset;
    let of = |wanted: Quantity| -> Vec<f64> {
        let is_heard = |c: &usize| {
            dataset.channels[*c].quantity(&dataset.machine) == wanted && !dataset.records[record].silent[*c]
        };
        (0..dataset.channels.len()).filter(is_heard).map(|c| task.weights.noise[record][c]).collect()
    };
    let accelerations = of(Quantity::Acceleration);
    if !accelerations.is_empty() {
        let sum: f64 = accelerations.iter().map(|noise| noise * noise).sum();
        return sum.sqrt() / accelerations.len() as f64;
    }
    let Some(noise) = of(Quantity::Position).first().copied() else { return 0.0 };
    let mut chance = Chance::default();
    let rows = dataset.records[record].len().min(NOISE_ROWS);
    let readings: Vec<f64> = (0..rows).map(|_| noise * chance.deviate()).collect();
    let forced = forcing(&readings, omega, dataset.records[record].spacing_s);
    (forced.iter().map(|a| a * a).sum::<f64>() / rows.max(1) as f64).sqrt()
}

/// Rows of simulated noise from which its effect is estimated.
const NOISE_ROWS: usize = 4000;

/// Corner frequency of the smoothing before a position's residual is differentiated, over the observer's
/// natural frequency (cycles per radian): at most 30 Hz.
const SMOOTH: f64 = 0.75;

/// The acceleration that causes the residual `r` of an anchored position: `r'' + sqrt(2) omega r' + omega^2
/// r`. These are the error dynamics of the observer.
fn forcing(residual: &[f64], omega: f64, dt: f64) -> Vec<f64> {
    let r = low_pass(residual, SMOOTH * omega, dt);
    let last = r.len() - 1;
    (0..r.len())
        .map(|k| {
            let [a, b, c] = [r[k.saturating_sub(1)], r[k], r[(k + 1).min(last)]];
            (a - 2.0 * b + c) / (dt * dt)
                + std::f64::consts::SQRT_2 * omega * (c - a) / (2.0 * dt)
                + omega * omega * b
        })
        .collect()
}

/// A first-order low-pass, forward and backward: second order with zero phase.
pub(crate) fn low_pass(series: &[f64], corner_hz: f64, spacing_s: f64) -> Vec<f64> {
    let keep = (-TAU * corner_hz * spacing_s).exp();
    let mut out = series.to_vec();
    for k in 1..out.len() {
        out[k] += keep * (out[k - 1] - out[k]);
    }
    for k in (1..out.len()).rev() {
        out[k - 1] += keep * (out[k] - out[k - 1]);
    }
    out
}
