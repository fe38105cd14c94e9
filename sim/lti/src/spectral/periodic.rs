//! Response from several periods of a periodic record: there is no leakage, and differences between periods
//! are noise.
//!
//! Source: Pintelon and Schoukens, System Identification: A Frequency Domain Approach (2nd ed.), section 2.5
//! (Wiley and IEEE Press, 2012).

use super::estimate::ResponseEstimate;
use super::fft::{require_pair, require_samples, transform};
use crate::domain::C64;
use crate::error::LtiError;

/// Records of input and output of a periodic experiment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeriodicRecord<'a> {
    pub input: &'a [f64],
    /// Output samples, as many.
    pub output: &'a [f64],
    /// Sample time, s.
    pub period_s: f64,
    pub samples_per_period: usize,
    /// Whole periods at the start that are ignored, until transients have decayed.
    pub transient_periods: usize,
}

/// Means over periods of the spectra of input and output at some lines, and the (co)variances of those means.
pub(crate) struct PeriodMeans {
    pub(crate) periods: usize,
    pub(crate) input: Vec<C64>,
    pub(crate) output: Vec<C64>,
    input_variance: Vec<f64>,
    pub(crate) output_variance: Vec<f64>,
    covariance: Vec<C64>,
}

/// Powers of the input's lines, and the variances of their means over the periods.
pub(crate) struct Spread {
    pub(crate) powers: Vec<f64>,
    pub(crate) variances: Vec<f64>,
}

impl PeriodicRecord<'_> {
    /// Power of the input on some lines, and its variance between periods.
    pub(crate) fn input_spread(&self, lines: &[usize]) -> Result<Spread, LtiError> {
        let means = self.means(lines)?;
        Ok(Spread {
            powers: means.input.iter().map(C64::norm_sqr).collect(),
            variances: means.input_variance,
        })
    }

    pub(crate) fn frequency_hz(&self, line: usize) -> f64 {
        line as f64 / (self.samples_per_period as f64 * self.period_s)
    }

    /// Averages of the spectra, scaled so that a sine of amplitude 1 gives a line of modulus 1.
    pub(crate) fn means(&self, lines: &[usize]) -> Result<PeriodMeans, LtiError> {
        require_pair(self.input, self.output, self.period_s)?;
        let n = self.samples_per_period;
        if n < 2 {
            return Err(LtiError::OutOfRange {
                quantity: "samples in a period",
                value: n as f64,
                range: "[2, inf)",
            });
        }
        if let Some(&line) = lines.iter().find(|line| **line > n / 2) {
            return Err(LtiError::OutOfRange {
                quantity: "line",
                value: line as f64,
                range: "[0, samples per period / 2]",
            });
        }
        require_samples((self.transient_periods + 2) * n, self.input.len())?;
        let first = self.transient_periods * n;
        let spectra = |record: &[f64]| -> Vec<Vec<C64>> {
            let periods = record[first..].chunks_exact(n);
            periods.map(|p| pick(&transform(p), lines, 2.0 / n as f64)).collect()
        };
        let (u, y) = (spectra(self.input), spectra(self.output));
        let periods = u.len();
        let mean = |spectra: &[Vec<C64>]| -> Vec<C64> {
            (0..lines.len()).map(|k| spectra.iter().map(|s| s[k]).sum::<C64>() / periods as f64).collect()
        };
        let (um, ym) = (mean(&u), mean(&y));
        let moment = |k: usize, a: &[Vec<C64>], am: &[C64], b: &[Vec<C64>], bm: &[C64]| -> C64 {
            let products = a.iter().zip(b).map(|(a, b)| (a[k] - am[k]) * (b[k] - bm[k]).conj());
            products.sum::<C64>() / (periods * (periods - 1)) as f64
        };
        Ok(PeriodMeans {
            periods,
            input_variance: (0..lines.len()).map(|k| moment(k, &u, &um, &u, &um).re).collect(),
            output_variance: (0..lines.len()).map(|k| moment(k, &y, &ym, &y, &ym).re).collect(),
            covariance: (0..lines.len()).map(|k| moment(k, &y, &ym, &u, &um)).collect(),
            input: um,
            output: ym,
        })
    }
}

fn pick(spectrum: &[C64], lines: &[usize], factor: f64) -> Vec<C64> {
    lines.iter().map(|&line| spectrum[line] * factor).collect()
}

impl PeriodMeans {
    /// Power of the output at line number k that the response to the input does not explain, less the noise.
    pub(crate) fn beyond(&self, k: usize, response: C64) -> f64 {
        let [left, noise] = self.left_and_noise(k, response);
        left - noise
    }

    /// Power of the output at line number k that the response to the input does not explain, and the part of
    /// it that is noise.
    pub(crate) fn left_and_noise(&self, k: usize, response: C64) -> [f64; 2] {
        [(self.output[k] - response * self.input[k]).norm_sqr(), self.spread(k, response)]
    }

    /// Variance of the output's mean less the response times the input's.
    fn spread(&self, k: usize, g: C64) -> f64 {
        (self.output_variance[k] + g.norm_sqr() * self.input_variance[k]
            - 2.0 * (g.conj() * self.covariance[k]).re)
            .max(0.0)
    }

    /// Response and its variance at line number k of the requested ones.
    pub(crate) fn response(&self, k: usize, frequency_hz: f64) -> Result<(C64, f64), LtiError> {
        let (u, y) = (self.input[k], self.output[k]);
        if u.norm_sqr() <= 0.0 {
            return Err(LtiError::NotExcited { frequency_hz });
        }
        let g = y / u;
        // First-order propagation of (u, y) to y / u.
        Ok((g, self.spread(k, g) / u.norm_sqr()))
    }
}

/// Response at the excited lines from the mean of the periods, with the variance between periods.
///
/// # Errors
/// [`LtiError::RecordTooShort`] for fewer than two periods after the transient; [`LtiError::NotExcited`];
/// [`LtiError::OutOfRange`] for a line beyond the Nyquist frequency; [`LtiError::RecordLengths`];
/// [`LtiError::NotFinite`].
pub fn periodic_response(record: &PeriodicRecord<'_>, lines: &[usize]) -> Result<ResponseEstimate, LtiError> {
    let means = record.means(lines)?;
    let mut estimate = ResponseEstimate::default();
    for (k, &line) in lines.iter().enumerate() {
        let frequency_hz = record.frequency_hz(line);
        let (response, variance) = means.response(k, frequency_hz)?;
        estimate.frequencies_hz.push(frequency_hz);
        estimate.response.push(response);
        estimate.variance.push(variance);
        estimate.degrees_of_freedom.push(2.0 * (means.periods - 1) as f64);
    }
    Ok(estimate)
}
