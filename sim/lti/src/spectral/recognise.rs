//! Recognises the excitation of a recorded machine, and with it the estimator for its response.

use super::fft::{require_samples, transform};
use super::periodic::Spread;
use super::sum_of_sines::{SineSum, find_sines};
use super::welch::{WelchSettings, cross_spectra};
use crate::domain::C64;
use crate::error::{LtiError, require_finite, require_positive};

/// A period repeats if its repetition differs by at most this share of the power.
const REPEATS: f64 = 1e-3;
/// Before the first repetition the difference must exceed this share: a slow record resembles itself one
/// sample later.
const DIFFERS: f64 = 0.5;
/// A record is a sum of sines if they explain this share of its power. For white noise the search explains
/// about two thirds.
const ALL_SINES: f64 = 0.97;
/// Number of spectral segments in the test for evenness.
const SEGMENTS: usize = 8;
/// Share of the power in the tested band.
const POWER: f64 = 0.995;
/// A record is silent while it differs by at most this share of the largest value. The minimum is the number
/// of samples between silences.
const SILENT: f64 = 1e-3;
const LEAST_ACTING: usize = 256;
/// Smallest number of lines of a band that does not begin at the lowest line.
const LEAST_LINES: usize = 8;
/// Smallest ratio of geometric to arithmetic mean of an even spectrum. White noise of [`SEGMENTS`] segments
/// has 0.95; one slope of 20 dB per decade over two decades has 0.08.
const EVEN: f64 = 0.3;
/// Largest change of the modulus from line to line in a smooth spectrum. Noise has 1 - pi/4 = 0.21.
const SMOOTH: f64 = 0.07;

/// The excitation of a recorded command.
#[derive(Debug, Clone, PartialEq)]
pub enum RecordedExcitation {
    Periodic {
        /// Samples after which the command repeats.
        samples_per_period: usize,
        /// Whole periods in the record, at least two.
        periods: usize,
    },
    /// Sines without a common period, or without a period that appears twice.
    Sines(SineSum),
    /// Noise with power over its whole band.
    Noise {
        /// Geometric over arithmetic mean of its spectrum, up to 1.
        evenness: f64,
    },
    /// An even and smooth spectrum: a chirp or a burst.
    Sweep,
    /// Any other command: some frequencies have far more power than others.
    Uneven {
        /// Geometric over arithmetic mean of its spectrum.
        evenness: f64,
    },
}

/// Recognises the excitation of a command: by its period, by its sines, else by the evenness and smoothness
/// of its spectrum.
///
/// # Errors
/// [`LtiError::RecordTooShort`] below 32 samples; [`LtiError::NotFinite`]; [`LtiError::OutOfRange`] for the
/// sample time.
pub fn recognise_excitation(command: &[f64], period_s: f64) -> Result<RecordedExcitation, LtiError> {
    require_positive("sample time (s)", period_s)?;
    require_finite("record", command)?;
    require_samples(32, command.len())?;
    let mean = command.iter().sum::<f64>() / command.len() as f64;
    let about: Vec<f64> = command.iter().map(|v| v - mean).collect();
    if let Some(samples_per_period) = repetition(&about) {
        return Ok(RecordedExcitation::Periodic {
            samples_per_period,
            periods: command.len() / samples_per_period,
        });
    }
    let sines = find_sines(command, period_s)?;
    if sines.explained >= ALL_SINES {
        return Ok(RecordedExcitation::Sines(sines));
    }
    let acting = acting(&about);
    let segment = acting.len() / SEGMENTS;
    let spectra = cross_spectra(acting, acting, period_s, &WelchSettings::hann(segment))?;
    let (first, last) = powered(&spectra.input);
    let band = &spectra.input[first..=last];
    let geometric =
        (band.iter().map(|p| p.max(f64::MIN_POSITIVE).ln()).sum::<f64>() / band.len() as f64).exp();
    let evenness = geometric / (band.iter().sum::<f64>() / band.len() as f64);
    if evenness < EVEN {
        return Ok(RecordedExcitation::Uneven { evenness });
    }
    let moduli: Vec<f64> =
        transform(acting)[first * SEGMENTS..last * SEGMENTS].iter().map(|v| v.norm()).collect();
    let steps: f64 = moduli.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    let sizes: f64 = moduli.windows(2).map(|pair| pair[1].powi(2) + pair[0].powi(2)).sum();
    Ok(if steps < SMOOTH * sizes {
        RecordedExcitation::Sweep
    } else {
        RecordedExcitation::Noise { evenness }
    })
}

/// A record without the silence at its ends, where it is constant; the whole record if too little would be
/// left.
fn acting(record: &[f64]) -> &[f64] {
    let size = record.iter().fold(0.0_f64, |size, v| size.max(v.abs()));
    let silent = |level: f64| move |v: &&f64| (**v - level).abs() <= SILENT * size;
    let (Some(&first), Some(&last)) = (record.first(), record.last()) else { return record };
    let before = record.iter().take_while(silent(first)).count();
    let after = record.iter().rev().take_while(silent(last)).count();
    let part = record
        .get(before.saturating_sub(1)..(record.len() + 1).saturating_sub(after.max(1)))
        .unwrap_or(record);
    if part.len() >= LEAST_ACTING { part } else { record }
}

/// First and last line of the band with nearly all power of a spectrum; it starts at the first line if it
/// would be narrow.
fn powered(spectrum: &[f64]) -> (usize, usize) {
    let whole: f64 = spectrum[1..].iter().sum();
    let upto = |share: f64| {
        let mut below = 0.0;
        let lines = spectrum[1..].iter().take_while(|power| {
            below += **power;
            below < share * whole
        });
        1 + lines.count()
    };
    let last = upto(POWER).max(4).min(spectrum.len() - 1);
    let first = upto(1.0 - POWER);
    // The lobe of a single sine is four lines wide.
    if last >= first + LEAST_LINES { (first, last) } else { (1, last) }
}

/// Number of samples after which a record repeats about its mean, at least twice. It is the first dip of the
/// difference between the record and its shifted copy, relative to the power. After de Cheveigne and
/// Kawahara, J. Acoust. Soc. Am. 111 (2002) 1917.
fn repetition(record: &[f64]) -> Option<usize> {
    let n = record.len();
    // Correlations at all lags at once: the transform of the padded record's power.
    let padded: Vec<f64> = record.iter().copied().chain(std::iter::repeat_n(0.0, n)).collect();
    let power: Vec<f64> = transform(&padded).iter().map(C64::norm_sqr).collect();
    let mirrored: Vec<f64> = power.iter().chain(power[1..n].iter().rev()).copied().collect();
    let correlation: Vec<f64> = transform(&mirrored).iter().map(|v| v.re / (2 * n) as f64).collect();
    let mut energy = vec![0.0; n + 1];
    for (i, value) in record.iter().enumerate() {
        energy[i + 1] = energy[i] + value * value;
    }
    let difference = |lag: usize| {
        let both = energy[n - lag] + energy[n] - energy[lag];
        if both > 0.0 { (both - 2.0 * correlation[lag]).max(0.0) / both } else { 1.0 }
    };
    let different = (1..=n / 2).find(|&lag| difference(lag) > DIFFERS)?;
    let close = (different..=n / 2).find(|&lag| difference(lag) < REPEATS)?;
    (close..=n / 2)
        .take_while(|&lag| difference(lag) < REPEATS)
        .min_by(|&a, &b| difference(a).total_cmp(&difference(b)))
}

/// Excited lines of a periodic input between two frequencies. Their amplitude is at least a hundredth of the
/// strongest one's, and ten times the difference between periods.
///
/// # Errors
/// As [`super::periodic_response`].
pub fn excited_lines(
    record: &super::PeriodicRecord<'_>,
    (low_hz, high_hz): (f64, f64),
) -> Result<Vec<usize>, LtiError> {
    const LEAST_AMPLITUDE: f64 = 0.01;
    const TIMES_NOISE: f64 = 10.0;
    let period_s = record.samples_per_period as f64 * record.period_s;
    let last =
        ((high_hz * period_s * (1.0 + 1e-9)).floor() as usize).min((record.samples_per_period - 1) / 2);
    let lines: Vec<usize> = ((low_hz * period_s * (1.0 - 1e-9)).ceil().max(1.0) as usize..=last).collect();
    let Spread { powers, variances } = record.input_spread(&lines)?;
    let strongest = powers.iter().copied().fold(0.0, f64::max);
    let excited = |k: usize| {
        powers[k] >= LEAST_AMPLITUDE.powi(2) * strongest && powers[k] > TIMES_NOISE.powi(2) * variances[k]
    };
    Ok(lines
        .iter()
        .enumerate()
        .filter(|(k, _)| strongest > 0.0 && excited(*k))
        .map(|(_, line)| *line)
        .collect())
}
