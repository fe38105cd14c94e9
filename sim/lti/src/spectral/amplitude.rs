//! Amplitude spectrum of a record and its dominant frequency.

use std::f64::consts::TAU;

use super::fft::{require_samples, transform};
use super::window::Window;
use crate::domain::C64;
use crate::error::{LtiError, require_finite, require_positive};
use crate::search::maximum;

/// One-sided amplitude spectrum: a sine of amplitude 1 on a line shows as 1.
#[derive(Debug, Clone, PartialEq)]
pub struct AmplitudeSpectrum {
    /// Frequencies, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Amplitudes, unit of the record.
    pub amplitudes: Vec<f64>,
}

/// Amplitude spectrum of a record, its mean removed.
///
/// # Errors
/// [`LtiError::RecordTooShort`] below four samples; [`LtiError::NotFinite`]; [`LtiError::OutOfRange`].
pub fn amplitude_spectrum(record: &[f64], period_s: f64, window: Window) -> Result<AmplitudeSpectrum, LtiError> {
    let (weighted, weight) = weighted(record, period_s, window)?;
    let n = record.len();
    let amplitude = |(k, line): (usize, &C64)| line.norm() / weight * if k == 0 || 2 * k == n { 1.0 } else { 2.0 };
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

/// Frequency (Hz) and amplitude of the strongest sine in a record between two frequencies: the maximum of the Hann-windowed Fourier transform
/// as a continuous function of frequency, not only on its lines. `None` where there is no line in the band or no power.
///
/// # Errors
/// As [`amplitude_spectrum`].
///
/// # Example
/// ```
/// let record: Vec<f64> = (0..500).map(|i| 3.0 * (std::f64::consts::TAU * 12.34 * f64::from(i) * 1e-3).sin()).collect();
/// let (frequency_hz, amplitude) = feeler_lti::spectral::dominant_frequency(&record, 1e-3, (1.0, 400.0))?.expect("one sine");
/// assert!((frequency_hz - 12.34).abs() < 0.02 && (amplitude - 3.0).abs() < 0.02);
/// # Ok::<(), feeler_lti::LtiError>(())
/// ```
pub fn dominant_frequency(record: &[f64], period_s: f64, (low_hz, high_hz): (f64, f64)) -> Result<Option<(f64, f64)>, LtiError> {
    let (weighted, weight) = weighted(record, period_s, Window::Hann)?;
    let spacing_hz = 1.0 / (record.len() as f64 * period_s);
    let spectrum = transform(&weighted);
    let in_band = |k: &usize| *k > 0 && (low_hz..=high_hz).contains(&(*k as f64 * spacing_hz));
    let strongest = (0..spectrum.len()).filter(in_band).max_by(|&i, &j| spectrum[i].norm_sqr().total_cmp(&spectrum[j].norm_sqr()));
    let Some(line) = strongest.filter(|&k| spectrum[k].norm_sqr() > 0.0) else { return Ok(None) };
    let amplitude = |frequency_hz: f64| -> Result<f64, LtiError> {
        let turn = TAU * frequency_hz * period_s;
        let sum: C64 = weighted.iter().enumerate().map(|(i, v)| C64::cis(-turn * i as f64) * v).sum();
        Ok(2.0 * sum.norm() / weight)
    };
    let centre = line as f64 * spacing_hz;
    let (low, high) = ((centre - spacing_hz).max(low_hz), (centre + spacing_hz).min(high_hz));
    maximum(low, high, amplitude).map(Some)
}
