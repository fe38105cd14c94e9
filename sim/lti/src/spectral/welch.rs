//! Averaged auto and cross spectra, and the responses estimated from them.
//!
//! Sources: Welch, IEEE Trans. Audio and Electroacoustics 15 (1967); Bendat and Piersol, Random Data (4th
//! ed.), chapters 6 and 9; Rocklin, Crowley and Vold, 3rd IMAC (1985) for Hv.

use super::estimate::ResponseEstimate;
use super::fft::{require_pair, require_samples, transform};
use super::window::Window;
use crate::domain::C64;
use crate::error::LtiError;

/// Segments of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WelchSettings {
    pub segment_samples: usize,
    /// Samples that neighbouring segments share; half of them suits the Hann window.
    pub overlap_samples: usize,
    pub window: Window,
}

impl WelchSettings {
    /// Hann windows with half overlap.
    pub fn hann(segment_samples: usize) -> Self {
        Self { segment_samples, overlap_samples: segment_samples / 2, window: Window::Hann }
    }
}

/// One-sided power spectral densities of an input and an output, and between them.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossSpectra {
    pub frequencies_hz: Vec<f64>,
    /// Density of the input, unit^2 / Hz.
    pub input: Vec<f64>,
    /// Density of the output, unit^2 / Hz.
    pub output: Vec<f64>,
    /// Density of conj(input) times output, unit^2 / Hz.
    pub cross: Vec<C64>,
    /// Equivalent number of independent averages of the segments.
    pub averages: f64,
}

/// The spectra from which a response is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Estimator {
    /// cross / input: unbiased by noise on the output; the choice if the input is known exactly.
    #[default]
    H1,
    /// output / conj(cross): unbiased by noise on the input.
    H2,
    /// Total least squares: equal noise on both, after scaling by the ratio of the spectra; |Hv|^2 = |H1 H2|.
    Hv,
}

/// Welch's averaged spectra of two records of equal length; the mean of each segment is removed.
///
/// # Errors
/// [`LtiError::RecordLengths`], [`LtiError::RecordTooShort`] for less than one segment,
/// [`LtiError::OutOfRange`] for a segment of less than two samples or an overlap of a whole one,
/// [`LtiError::NotFinite`].
pub fn cross_spectra(
    input: &[f64],
    output: &[f64],
    period_s: f64,
    settings: &WelchSettings,
) -> Result<CrossSpectra, LtiError> {
    require_pair(input, output, period_s)?;
    let WelchSettings { segment_samples: n, overlap_samples, window } = *settings;
    if n < 2 {
        return Err(LtiError::OutOfRange {
            quantity: "samples in a segment",
            value: n as f64,
            range: "[2, inf)",
        });
    }
    if overlap_samples >= n {
        return Err(LtiError::OutOfRange {
            quantity: "overlapping samples",
            value: overlap_samples as f64,
            range: "[0, segment)",
        });
    }
    require_samples(n, input.len())?;
    let weights = window.weights(n);
    let hop = n - overlap_samples;
    let segments = (input.len() - n) / hop + 1;
    let lines = n / 2 + 1;
    let mut sums = CrossSpectra {
        frequencies_hz: (0..lines).map(|k| k as f64 / (n as f64 * period_s)).collect(),
        input: vec![0.0; lines],
        output: vec![0.0; lines],
        cross: vec![C64::new(0.0, 0.0); lines],
        averages: effective_averages(&weights, hop, segments),
    };
    let windowed = |record: &[f64]| {
        let mean = record.iter().sum::<f64>() / n as f64;
        transform(&record.iter().zip(&weights).map(|(v, w)| (v - mean) * w).collect::<Vec<f64>>())
    };
    for start in (0..segments).map(|s| s * hop) {
        sums.add(&windowed(&input[start..start + n]), &windowed(&output[start..start + n]));
    }
    let power = weights.iter().map(|w| w * w).sum::<f64>();
    sums.scale(|k| one_sided(k, n) * period_s / (power * segments as f64));
    Ok(sums)
}

/// Spectra of whole records, averaged over `2 half_width + 1` neighbouring lines instead of segments. They
/// suit chirps, bursts and other transients that begin and end at rest, and therefore have no leakage. Lines
/// are those of whole averages, without the zeroth.
///
/// # Errors
/// As [`cross_spectra`]; [`LtiError::RecordTooShort`] if the record has not even one whole average.
pub fn smoothed_spectra(
    input: &[f64],
    output: &[f64],
    period_s: f64,
    half_width: usize,
) -> Result<CrossSpectra, LtiError> {
    require_pair(input, output, period_s)?;
    let n = input.len();
    let width = 2 * half_width + 1;
    require_samples(2 * width + 2, n)?;
    let (u, y) = (transform(input), transform(output));
    // Line 0 contains the offset; line n / 2 of an even record is real, and omitted too.
    let bands = ((n - 1) / 2) / width;
    let mut sums = CrossSpectra {
        frequencies_hz: (0..bands)
            .map(|b| (1 + b * width + half_width) as f64 / (n as f64 * period_s))
            .collect(),
        input: vec![0.0; bands],
        output: vec![0.0; bands],
        cross: vec![C64::new(0.0, 0.0); bands],
        averages: width as f64,
    };
    for offset in 0..width {
        let band = |values: &[C64]| (0..bands).map(|b| values[1 + b * width + offset]).collect::<Vec<C64>>();
        sums.add(&band(&u), &band(&y));
    }
    sums.scale(|_| 2.0 * period_s / (n * width) as f64);
    Ok(sums)
}

/// Factor with which a line of a two-sided spectrum enters the one-sided one.
fn one_sided(line: usize, samples: usize) -> f64 {
    if line == 0 || 2 * line == samples { 1.0 } else { 2.0 }
}

/// Independent averages in overlapping segments of white noise: `n / (1 + 2 sum (1 - k/n) rho_k)`, `rho_k`
/// the squared correlation of windows k hops apart (Welch 1967, equation 11).
fn effective_averages(weights: &[f64], hop: usize, segments: usize) -> f64 {
    let power: f64 = weights.iter().map(|w| w * w).sum();
    let mut spread = 1.0;
    for k in (1..segments).take_while(|k| k * hop < weights.len()) {
        let overlap: f64 = weights[k * hop..].iter().zip(weights).map(|(a, b)| a * b).sum();
        spread += 2.0 * (1.0 - k as f64 / segments as f64) * (overlap / power).powi(2);
    }
    segments as f64 / spread
}

impl CrossSpectra {
    /// Spectra of several records with the same lines, each weighted by its number of averages.
    ///
    /// # Errors
    /// [`LtiError::RecordTooShort`] for none; [`LtiError::RecordLengths`] if numbers of lines differ.
    pub fn averaged(parts: &[Self]) -> Result<Self, LtiError> {
        let Some((first, others)) = parts.split_first() else {
            return Err(LtiError::RecordTooShort { needed: 1, found: 0 });
        };
        let mut sum = first.clone();
        let weight: f64 = parts.iter().map(|part| part.averages).sum();
        sum.scale(|_| first.averages / weight);
        for part in others {
            if part.cross.len() != sum.cross.len() {
                return Err(LtiError::RecordLengths { left: sum.cross.len(), right: part.cross.len() });
            }
            let share = part.averages / weight;
            for k in 0..sum.cross.len() {
                sum.input[k] += share * part.input[k];
                sum.output[k] += share * part.output[k];
                sum.cross[k] += part.cross[k] * share;
            }
        }
        sum.averages = weight;
        Ok(sum)
    }

    fn add(&mut self, u: &[C64], y: &[C64]) {
        for (k, (u, y)) in u.iter().zip(y).enumerate() {
            self.input[k] += u.norm_sqr();
            self.output[k] += y.norm_sqr();
            self.cross[k] += u.conj() * y;
        }
    }

    fn scale(&mut self, factor: impl Fn(usize) -> f64) {
        for k in 0..self.input.len() {
            let f = factor(k);
            self.input[k] *= f;
            self.output[k] *= f;
            self.cross[k] *= f;
        }
    }

    /// Ordinary coherence in [0, 1] at each frequency; 0 if a record has no power. Not meaningful (1) for a
    /// single average.
    pub fn coherence(&self) -> Vec<f64> {
        (0..self.input.len())
            .map(|k| {
                let power = self.input[k] * self.output[k];
                if power > 0.0 { (self.cross[k].norm_sqr() / power).min(1.0) } else { 0.0 }
            })
            .collect()
    }

    /// The response by one of the estimators, at the frequencies between two ends at which input and cross
    /// spectrum have power.
    ///
    /// # Errors
    /// [`LtiError::RecordTooShort`] for fewer than two averages, which do not give a variance.
    pub fn response(
        &self,
        estimator: Estimator,
        low_hz: f64,
        high_hz: f64,
    ) -> Result<ResponseEstimate, LtiError> {
        if self.averages < 1.5 {
            return Err(LtiError::RecordTooShort { needed: 2, found: self.averages as usize });
        }
        let coherence = self.coherence();
        let nu = 2.0 * (self.averages - 1.0);
        let mut estimate = ResponseEstimate::default();
        let mut kept = Vec::new();
        for (k, &frequency_hz) in self.frequencies_hz.iter().enumerate() {
            let (suu, syy, suy) = (self.input[k], self.output[k], self.cross[k]);
            if !(low_hz..=high_hz).contains(&frequency_hz) || suu <= 0.0 || suy.norm_sqr() <= 0.0 {
                continue;
            }
            let response = match estimator {
                Estimator::H1 => suy / suu,
                Estimator::H2 => C64::new(syy, 0.0) / suy.conj(),
                Estimator::Hv => suy / suy.norm() * (syy / suu).sqrt(),
            };
            estimate.frequencies_hz.push(frequency_hz);
            estimate.response.push(response);
            estimate.variance.push(response.norm_sqr() * (1.0 - coherence[k]) / coherence[k] * 2.0 / nu);
            estimate.degrees_of_freedom.push(nu);
            kept.push(coherence[k]);
        }
        estimate.coherence = Some(kept);
        Ok(estimate)
    }
}
