//! Sines of any frequencies in one record: search, joint fit, and the response at each of them.
//!
//! The sines need not have a common period, nor the record whole periods. All are fitted together by weighted
//! least squares with a Hann window. The window reduces the weight of the transient at the start, and
//! neighbours may be as close as about two lines of the record. Source of the fit: Stoica and Moses, Spectral
//! Analysis of Signals (Prentice Hall, 2005), section 4.3.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

use super::estimate::ResponseEstimate;
use super::fft::{require_pair, require_samples, transform};
use crate::domain::C64;
use crate::error::{LtiError, require_finite, require_positive};

/// Smallest distance between sines, and of a sine from zero, in lines of the record (the inverse of its
/// length).
const LEAST_SPACING: f64 = 1.7;
/// Largest number of sines in the search; a record with more is not a designed sum of sines.
const MOST_SINES: usize = 400;
/// Number of search rounds; each finds sines of at least [`SHARE_OF_ROUND`] of the largest that remains.
const ROUNDS: usize = 8;
const SHARE_OF_ROUND: f64 = 0.3;
/// Smallest amplitude of a sine relative to the strongest within an octave, and to the strongest of all;
/// weaker ones are noise or feedback.
const LEAST_NEARBY: f64 = 0.1;
const LEAST_OF_ALL: f64 = 0.01;
/// The search ends when the unexplained share of the power is below this.
const ALL_EXPLAINED: f64 = 1e-6;
/// Refinements of the frequencies after each round, each by at most this number of lines.
const REFINEMENTS: usize = 4;
const LONGEST_STEP: f64 = 0.3;
/// Lines on each side of a sine that give the noise there, and the smallest number of them that must remain.
const NOISE_LINES: usize = 8;
const LEAST_NOISE_LINES: f64 = 6.0;
/// Lines of noise that the fit of one sine removes under a Hann window: 2 (1 + 2/3) - (1 + 1/2). The number
/// follows from the transforms of the window and of its square.
const LINES_TAKEN: f64 = 11.0 / 6.0;
/// Lines per independent line under a Hann window: 1 + 2 (4/9 + 1/36).
const LINES_PER_INDEPENDENT: f64 = 35.0 / 18.0;

/// The sines of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct SineSum {
    /// Frequencies, Hz, rising.
    pub frequencies_hz: Vec<f64>,
    /// Amplitudes, unit of the record.
    pub amplitudes: Vec<f64>,
    /// Share of the record's power that they explain, Hann-weighted and without a straight line.
    pub explained: f64,
}

/// Finds the sines of a record, down to a tenth of the strongest within an octave. In noise it finds many
/// that explain little.
///
/// # Errors
/// [`LtiError::RecordTooShort`] below sixteen samples; [`LtiError::NotFinite`]; [`LtiError::OutOfRange`] for
/// the sample time.
///
/// # Example
/// ```
/// let t = |i: u32| f64::from(i) * 1e-3;
/// let record: Vec<f64> = (0..2000).map(|i| (75.3 * t(i)).sin() + 0.4 * (121.9 * t(i)).cos()).collect();
/// let found = feeler_lti::spectral::find_sines(&record, 1e-3)?;
/// assert_eq!(found.frequencies_hz.len(), 2);
/// assert!((found.frequencies_hz[1] * std::f64::consts::TAU - 121.9).abs() < 1e-6);
/// assert!(found.explained > 0.999_999);
/// # Ok::<(), feeler_lti::LtiError>(())
/// ```
pub fn find_sines(record: &[f64], period_s: f64) -> Result<SineSum, LtiError> {
    require_positive("sample time (s)", period_s)?;
    require_finite("record", record)?;
    require_samples(16, record.len())?;
    let line = TAU / record.len() as f64;
    let mut fit = Fit::new(record, Vec::new())?;
    let whole = fit.power_left();
    for _ in 0..ROUNDS {
        if fit.power_left() <= ALL_EXPLAINED * whole {
            break;
        }
        let found = candidates(&fit, line);
        if found.is_empty() || fit.angles.len() + found.len() > MOST_SINES {
            break;
        }
        let mut angles = [fit.angles, found].concat();
        angles.sort_by(f64::total_cmp);
        fit = Fit::new(record, angles)?;
        for _ in 0..REFINEMENTS {
            fit = Fit::new(record, fit.refined(line))?;
        }
    }
    let explained = if whole > 0.0 { 1.0 - fit.power_left() / whole } else { 0.0 };
    let frequencies_hz = fit.angles.iter().map(|w| w / (TAU * period_s)).collect();
    Ok(SineSum { frequencies_hz, amplitudes: fit.amplitudes.iter().map(|a| a.norm()).collect(), explained })
}

/// Response at the frequencies of the exciting sines, from input and output fitted with all of them together.
/// The variance comes from the residual beside each frequency: noise and nonlinear distortion, which one
/// record of this kind cannot separate. The coherence is the sine's share of the output's power in its own
/// line.
///
/// # Errors
/// [`LtiError::RecordLengths`], [`LtiError::RecordTooShort`], [`LtiError::NotFinite`];
/// [`LtiError::OutOfRange`] for a frequency not between zero and half the sample rate.
/// [`LtiError::NotExcited`] for one that the input does not have, or for two that cannot be separated.
pub fn response_at_sines(
    input: &[f64],
    output: &[f64],
    period_s: f64,
    frequencies_hz: &[f64],
) -> Result<ResponseEstimate, LtiError> {
    require_pair(input, output, period_s)?;
    let n = input.len();
    require_samples((4 * frequencies_hz.len()).max(16), n)?;
    if let Some(&value) = frequencies_hz.iter().find(|f| !(**f > 0.0 && **f * period_s < 0.5)) {
        return Err(LtiError::OutOfRange {
            quantity: "frequency (Hz)",
            value,
            range: "(0, half the sample rate)",
        });
    }
    let angles: Vec<f64> = frequencies_hz.iter().map(|f| TAU * f * period_s).collect();
    let (u, y) = (Fit::new(input, angles.clone())?, Fit::new(output, angles.clone())?);
    let (left_u, left_y) = (transform(&u.weighted_rest()), transform(&y.weighted_rest()));
    let scale = 2.0 / hann(n).iter().sum::<f64>();
    let mut estimate = ResponseEstimate::default();
    let mut coherence = Vec::new();
    for (k, &frequency_hz) in frequencies_hz.iter().enumerate() {
        let power = u.amplitudes[k].norm_sqr();
        if power <= 0.0 {
            return Err(LtiError::NotExcited { frequency_hz });
        }
        let response = y.amplitudes[k] / u.amplitudes[k];
        let (lines, free) = noise_lines(&angles, angles[k], n);
        // The output due to the residual of the input is not noise.
        let left: f64 = lines.map(|i| (left_y[i] - response * left_u[i]).norm_sqr()).sum();
        let variance = scale * scale * left / free / power;
        estimate.frequencies_hz.push(frequency_hz);
        estimate.response.push(response);
        estimate.variance.push(variance);
        estimate.degrees_of_freedom.push(2.0 * free / LINES_PER_INDEPENDENT);
        coherence.push(1.0 / (1.0 + variance / response.norm_sqr().max(f64::MIN_POSITIVE)));
    }
    estimate.coherence = Some(coherence);
    Ok(estimate)
}

/// Lines about a frequency, and the number of them that the fit leaves to the noise.
fn noise_lines(angles: &[f64], angle: f64, n: usize) -> (std::ops::RangeInclusive<usize>, f64) {
    let place = |w: f64| w * n as f64 / TAU;
    let (middle, last) = (place(angle).round() as usize, (n - 1) / 2);
    let mut half = NOISE_LINES;
    loop {
        let lines = middle.saturating_sub(half).max(1)..=(middle + half).min(last);
        let within = angles
            .iter()
            .filter(|w| (*lines.start() as f64 - 0.5..=*lines.end() as f64 + 0.5).contains(&place(**w)))
            .count();
        let all = (lines.end() + 1 - lines.start()) as f64;
        let free = all - LINES_TAKEN * within as f64;
        if free >= LEAST_NOISE_LINES || half > n {
            return (lines, free.max(1.0));
        }
        half *= 2;
    }
}

/// Peaks of the residual of a fit that may be sines, rad per sample.
fn candidates(fit: &Fit, line: f64) -> Vec<f64> {
    let scale = 2.0 / hann(fit.rest.len()).iter().sum::<f64>();
    let spectrum: Vec<f64> = transform(&fit.weighted_rest()).iter().map(|v| scale * v.norm()).collect();
    let largest = spectrum.iter().copied().fold(0.0, f64::max);
    let strongest = fit.amplitudes.iter().map(|a| a.norm()).fold(largest, f64::max);
    let nearby = |angle: f64| {
        let beside =
            fit.angles.iter().zip(&fit.amplitudes).filter(|(w, _)| (0.5..=2.0).contains(&(**w / angle)));
        beside.map(|(_, a)| a.norm()).fold(0.0, f64::max)
    };
    let mut peaks: Vec<(f64, f64)> = Vec::new();
    for i in 2..spectrum.len().saturating_sub(1) {
        let (before, peak, after) = (spectrum[i - 1], spectrum[i], spectrum[i + 1]);
        let enough = (SHARE_OF_ROUND * largest).max(LEAST_OF_ALL * strongest);
        if peak < before || peak <= after || peak < enough {
            continue;
        }
        // For a Hann window, the ratio of the larger neighbour to the peak gives the distance of the sine
        // from its line.
        let (toward, neighbour) = if after > before { (1.0, after) } else { (-1.0, before) };
        let off = ((2.0 * neighbour - peak) / (neighbour + peak)).clamp(0.0, 0.5);
        let angle = line * (i as f64 + toward * off);
        if peak >= LEAST_NEARBY * nearby(angle) {
            peaks.push((peak, angle));
        }
    }
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut taken: Vec<f64> = Vec::new();
    for (_, angle) in peaks {
        let clear = |others: &[f64]| others.iter().all(|w| (w - angle).abs() >= LEAST_SPACING * line);
        if clear(&fit.angles) && clear(&taken) {
            taken.push(angle);
        }
    }
    taken
}

/// A straight line and sines, fitted to a record with Hann's weights; samples count from the middle of the
/// record.
struct Fit {
    /// Rad per sample, rising.
    angles: Vec<f64>,
    /// A sine is Re(amplitude exp(j angle m)).
    amplitudes: Vec<C64>,
    /// The record without the straight line and the sines.
    rest: Vec<f64>,
}

impl Fit {
    fn new(record: &[f64], angles: Vec<f64>) -> Result<Self, LtiError> {
        let n = record.len();
        let weights = hann(n);
        let weighted: Vec<f64> = record.iter().zip(&weights).map(|(v, w)| v * w).collect();
        let ramp: Vec<f64> = weights.iter().enumerate().map(|(i, w)| w * place(i, n)).collect();
        let kernel = |angle: f64| window_transform(angle, n);
        let sums: Vec<C64> = angles.iter().map(|&w| against(&weighted, w)).collect();
        let leans: Vec<f64> = angles.iter().map(|&w| -against(&ramp, w).im).collect();
        // About the middle, cosines and the mean are even, sines and the slope are odd: two systems of half
        // the size.
        let count = angles.len() + 1;
        let even = DMatrix::from_fn(count, count, |i, j| match (i, j) {
            (0, 0) => kernel(0.0),
            (0, k) | (k, 0) => kernel(angles[k - 1]),
            _ => 0.5 * (kernel(angles[i - 1] - angles[j - 1]) + kernel(angles[i - 1] + angles[j - 1])),
        });
        let odd = DMatrix::from_fn(count, count, |i, j| match (i, j) {
            (0, 0) => ramp.iter().enumerate().map(|(i, w)| w * place(i, n)).sum(),
            (0, k) | (k, 0) => leans[k - 1],
            _ => 0.5 * (kernel(angles[i - 1] - angles[j - 1]) - kernel(angles[i - 1] + angles[j - 1])),
        });
        let slope: f64 = ramp.iter().zip(record).map(|(w, v)| w * v).sum();
        let right_even =
            DVector::from_fn(count, |i, _| if i == 0 { weighted.iter().sum() } else { sums[i - 1].re });
        let right_odd = DVector::from_fn(count, |i, _| if i == 0 { slope } else { -sums[i - 1].im });
        let unknown = || LtiError::NotExcited { frequency_hz: 0.0 };
        let (cosines, sines) = (
            even.cholesky().ok_or_else(unknown)?.solve(&right_even),
            odd.cholesky().ok_or_else(unknown)?.solve(&right_odd),
        );
        let amplitudes: Vec<C64> = (1..count).map(|k| C64::new(cosines[k], -sines[k])).collect();
        let mut rest: Vec<f64> =
            record.iter().enumerate().map(|(i, v)| v - cosines[0] - sines[0] * place(i, n)).collect();
        for (&angle, &amplitude) in angles.iter().zip(&amplitudes) {
            let turn = C64::cis(angle);
            let mut now = amplitude * C64::cis(-0.5 * angle * (n - 1) as f64);
            for value in &mut rest {
                *value -= now.re;
                now *= turn;
            }
        }
        Ok(Self { angles, amplitudes, rest })
    }

    fn weighted_rest(&self) -> Vec<f64> {
        self.rest.iter().zip(hann(self.rest.len())).map(|(v, w)| v * w).collect()
    }

    fn power_left(&self) -> f64 {
        self.rest.iter().zip(hann(self.rest.len())).map(|(v, w)| v * v * w).sum()
    }

    /// Angles after one Gauss-Newton step for each sine separately; neighbours hardly matter at this spacing.
    fn refined(&self, line: f64) -> Vec<f64> {
        let n = self.rest.len();
        let weights = hann(n);
        let middle = 0.5 * (n - 1) as f64;
        let moment: Vec<f64> = self
            .rest
            .iter()
            .zip(&weights)
            .enumerate()
            .map(|(i, (v, w))| v * w * (i as f64 - middle))
            .collect();
        let spread: f64 = weights.iter().enumerate().map(|(i, w)| w * (i as f64 - middle).powi(2)).sum();
        let stepped = |(&angle, amplitude): (&f64, &C64)| {
            let lean = against(&moment, angle);
            let step = 2.0 * ((C64::i() * amplitude).conj() * lean).re
                / (amplitude.norm_sqr() * spread).max(f64::MIN_POSITIVE);
            (angle + step.clamp(-LONGEST_STEP * line, LONGEST_STEP * line)).clamp(line, PI - line)
        };
        let moved: Vec<f64> = self.angles.iter().zip(&self.amplitudes).map(stepped).collect();
        // A step that would merge two sines is rejected.
        let apart = |i: usize, j: Option<usize>| {
            j.and_then(|j| moved.get(j)).is_none_or(|w| (w - moved[i]).abs() > 0.7 * LEAST_SPACING * line)
        };
        (0..moved.len())
            .map(
                |i| {
                    if apart(i, i.checked_sub(1)) && apart(i, Some(i + 1)) {
                        moved[i]
                    } else {
                        self.angles[i]
                    }
                },
            )
            .collect()
    }
}

/// Position of a sample from -1/2 to 1/2.
fn place(i: usize, n: usize) -> f64 {
    (i as f64 - 0.5 * (n - 1) as f64) / n as f64
}

/// Hann's weights, symmetrical about the middle of the record.
fn hann(n: usize) -> Vec<f64> {
    (0..n).map(|i| 0.5 + 0.5 * (TAU * place(i, n)).cos()).collect()
}

/// Sum of Hann's weights times cos(angle m), m counted from the middle.
fn window_transform(angle: f64, n: usize) -> f64 {
    let comb = |w: f64| {
        let half = 0.5 * w;
        if half.sin().abs() < 1e-12 { n as f64 } else { (n as f64 * half).sin() / half.sin() }
    };
    let line = TAU / n as f64;
    0.5 * comb(angle) + 0.25 * (comb(angle - line) + comb(angle + line))
}

/// Sum of values times exp(-j angle m), m counted from the middle.
fn against(values: &[f64], angle: f64) -> C64 {
    let turn = C64::cis(-angle);
    let mut now = C64::cis(0.5 * angle * (values.len() - 1) as f64);
    let mut sum = C64::new(0.0, 0.0);
    for value in values {
        sum += now * *value;
        now *= turn;
    }
    sum
}
