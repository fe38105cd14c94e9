//! Sines of known frequency: fit, and the stepped-sine response.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::estimate::ResponseEstimate;
use super::fft::{require_pair, require_samples};
use crate::domain::C64;
use crate::error::{LtiError, require_finite, require_positive};

/// A sine fitted to a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineFit {
    /// Complex amplitude: the sine is Re(amplitude exp(j 2 pi f t)), t from the first sample.
    pub amplitude: C64,
    /// Offset at the middle of the record.
    pub offset: f64,
    /// Variance of the complex amplitude, with the residual as white noise.
    pub variance: f64,
}

/// Least-squares fit of a sine of known frequency, an offset and a drift. The record need not have whole
/// periods.
///
/// # Errors
/// [`LtiError::RecordTooShort`] below five samples; [`LtiError::OutOfRange`] for a frequency not between zero
/// and half the sample rate. [`LtiError::NotFinite`]; [`LtiError::NotExcited`] if the record is too short to
/// separate sine and drift.
pub fn fit_sine(record: &[f64], period_s: f64, frequency_hz: f64) -> Result<SineFit, LtiError> {
    require_positive("sample time (s)", period_s)?;
    require_finite("record", record)?;
    let n = record.len();
    require_samples(5, n)?;
    if !(frequency_hz > 0.0 && frequency_hz * period_s < 0.5) {
        return Err(LtiError::OutOfRange {
            quantity: "frequency (Hz)",
            value: frequency_hz,
            range: "(0, half the sample rate)",
        });
    }
    let middle = 0.5 * (n - 1) as f64;
    let regressors = DMatrix::from_fn(n, 4, |i, column| {
        let angle = TAU * frequency_hz * period_s * i as f64;
        match column {
            0 => angle.cos(),
            1 => -angle.sin(),
            2 => 1.0,
            _ => (i as f64 - middle) / n as f64,
        }
    });
    let observed = DVector::from_column_slice(record);
    let decomposition = regressors.clone().qr();
    let r_inverse = decomposition.r().try_inverse().ok_or(LtiError::NotExcited { frequency_hz })?;
    let solution = &r_inverse * (decomposition.q().transpose() * &observed);
    let left = (observed - regressors * &solution).norm_squared();
    let noise = left / (n - 4) as f64;
    Ok(SineFit {
        amplitude: C64::new(solution[0], solution[1]),
        offset: solution[2],
        variance: noise * (r_inverse.row(0).norm_squared() + r_inverse.row(1).norm_squared()),
    })
}

/// Steady records at one frequency of a stepped sine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteppedSinePoint<'a> {
    pub frequency_hz: f64,
    /// Input samples, after the transient.
    pub input: &'a [f64],
    /// Output samples, as many.
    pub output: &'a [f64],
}

/// Response at each frequency of a stepped sine, in the given order.
///
/// # Errors
/// Those of [`fit_sine`]; [`LtiError::RecordLengths`]; [`LtiError::NotExcited`] if the input has no sine at
/// the frequency.
pub fn stepped_sine(points: &[SteppedSinePoint<'_>], period_s: f64) -> Result<ResponseEstimate, LtiError> {
    let mut estimate = ResponseEstimate::default();
    for &SteppedSinePoint { frequency_hz, input, output } in points {
        require_pair(input, output, period_s)?;
        let (u, y) = (fit_sine(input, period_s, frequency_hz)?, fit_sine(output, period_s, frequency_hz)?);
        if u.amplitude.norm_sqr() <= 0.0 {
            return Err(LtiError::NotExcited { frequency_hz });
        }
        let g = y.amplitude / u.amplitude;
        estimate.frequencies_hz.push(frequency_hz);
        estimate.response.push(g);
        estimate.variance.push((y.variance + g.norm_sqr() * u.variance) / u.amplitude.norm_sqr());
        estimate.degrees_of_freedom.push((input.len() - 4) as f64);
    }
    Ok(estimate)
}
