//! Amplitude spectrum of a record and its dominant frequency.

use std::f64::consts::TAU;

use super::fft::{require_samples, transform};
use super::window::Window;
use crate::domain::C64;
use crate::error::{LtiError, require_finite, require_positive};
use crate::search::largest;

/// One-sided amplitude spectrum: a sine of amplitude 1 on a line shows as 1.
#[derive(Debug, Clone, PartialEq)]
pub struct AmplitudeSpectrum {
    pub frequencies_hz: Vec<f64>,
    /// Amplitudes, unit of the record.
    pub amplitudes: Vec<f64>,
}

/// Amplitude spectrum of a record, its mean removed.
///
/// # Errors
/// [`LtiError::RecordTooShort`] below four samples; [`LtiError::NotFinite`]; [`LtiError::OutOfRange`].
pub fn amplitude_spectrum(
    record: &[f64],
    period_s: f64,
    window: Window,
) -> Result<AmplitudeSpectrum, LtiError> {
    let (weighted, weight) = weighted(record, period_s, window)?;
    let n = record.len();
    let amplitude =
        |(k, line): (usize, &C64)| line.norm() / weight * if k == 0 || 2 * k == n { 1.0 } else { 2.0 };
    Ok(AmplitudeSpectrum {
        frequencies_hz: (0..=n / 2).map(|k| k as f64 / (n as f64 * period_s)).collect(),
        amplitudes: transform(&weighted).iter().enumerate().map(amplitude).collect(),
    })
}

/// The record less its mean, weighted, and the sum of the weights.
fn weighted(record: &[f64], period_s: f64, window: Window) -> Result<(Vec<f64>, f64), LtiError> {
    require_positive("sample time (s)", period_s)?;
    require_finite("record", record)?;
    require_samples(4, record.len())?;
    let weights = window.weights(record.len());
    let mean = record.iter().sum::<f64>() / record.len() as f64;
    Ok((record.iter().zip(&weights).map(|(v, w)| (v - mean) * w).collect(), weights.iter().sum()))
}

/// Frequency (Hz) and amplitude of the strongest sine in a record between two frequencies. It is the maximum
/// of the Hann-windowed Fourier transform as a continuous function of frequency, not only on its lines.
/// `None` if there is no line in the band or no power.
///
/// # Errors
/// As [`amplitude_spectrum`].
///
/// # Example
/// ```
/// let record: Vec<f64> = (0..500)
///     .map(|i| 3.0 * (std::f64::consts::TAU * 12.34 * f64::from(i) * 1e-3).sin())
///     .collect();
/// let (frequency_hz, amplitude) =
///     feeler_lti::spectral::dominant_frequency(&record, 1e-3, (1.0, 400.0))?.expect("one sine");
/// assert!((frequency_hz - 12.34).abs() < 0.02 && (amplitude - 3.0).abs() < 0.02);
/// # Ok::<(), feeler_lti::LtiError>(())
/// ```
pub fn dominant_frequency(
    record: &[f64],
    period_s: f64,
    (low_hz, high_hz): (f64, f64),
) -> Result<Option<(f64, f64)>, LtiError> {
    let (weighted, weight) = weighted(record, period_s, Window::Hann)?;
    let spacing_hz = 1.0 / (record.len() as f64 * period_s);
    let spectrum = transform(&weighted);
    let in_band = |k: &usize| *k > 0 && (low_hz..=high_hz).contains(&(*k as f64 * spacing_hz));
    let strongest = (0..spectrum.len())
        .filter(in_band)
        .max_by(|&i, &j| spectrum[i].norm_sqr().total_cmp(&spectrum[j].norm_sqr()));
    let Some(line) = strongest.filter(|&k| spectrum[k].norm_sqr() > 0.0) else { return Ok(None) };
    let centre = line as f64 * spacing_hz;
    let (low, high) = ((centre - spacing_hz).max(low_hz), (centre + spacing_hz).min(high_hz));
    let turns_per_hz = TAU * period_s;
    let phase = largest(low * turns_per_hz, high * turns_per_hz, centre * turns_per_hz, |phase| {
        let [sum, first, second] = moments(&weighted, phase);
        // Half of the slope and of the curvature of |sum|^2.
        [(sum.conj() * first).im, first.norm_sqr() - (sum.conj() * second).re]
    });
    let [sum, ..] = moments(&weighted, phase);
    Ok(Some((phase / turns_per_hz, 2.0 * sum.norm() / weight)))
}

/// Samples whose phase factors come from one table.
const BLOCK: usize = 64;

/// `sum_k k^m v[k] exp(-i phase k)` for m = 0, 1, 2, with k counted from the middle of the record. These give
/// the transform at any frequency, and its first two derivatives by the phase per sample.
fn moments(record: &[f64], phase: f64) -> [C64; 3] {
    let table: [[f64; 6]; BLOCK] = std::array::from_fn(|j| {
        let (turn, j) = (C64::cis(-phase * j as f64), j as f64);
        [turn.re, turn.im, j * turn.re, j * turn.im, j * j * turn.re, j * j * turn.im]
    });
    let middle = 0.5 * record.len() as f64;
    let mut moments = [C64::default(); 3];
    for (block, values) in record.chunks(BLOCK).enumerate() {
        let mut sums = [0.0; 6];
        for (value, turns) in values.iter().zip(&table) {
            for (sum, turn) in sums.iter_mut().zip(turns) {
                *sum += value * turn;
            }
        }
        let [s0, s1, s2] =
            [C64::new(sums[0], sums[1]), C64::new(sums[2], sums[3]), C64::new(sums[4], sums[5])];
        let start = (block * BLOCK) as f64 - middle;
        let turn = C64::cis(-phase * start);
        moments[0] += turn * s0;
        moments[1] += turn * (s1 + s0 * start);
        moments[2] += turn * (s2 + s1 * (2.0 * start) + s0 * (start * start));
    }
    moments
}
