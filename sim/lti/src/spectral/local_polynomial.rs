//! Local polynomial method: response from one short record of noise.
//!
//! Near each line both the response and the leakage (the transients before and after the record) are smooth.
//! They are fitted as polynomials over a few neighbouring lines. The noise-like input is not smooth, which
//! separates the two. Source: Pintelon, Schoukens, Vandersteen and Barbe, Mechanical Systems and Signal
//! Processing 24 (2010) 573.

use nalgebra::{DMatrix, DVector};

use super::estimate::ResponseEstimate;
use super::fft::{require_pair, require_samples, transform};
use crate::domain::C64;
use crate::error::LtiError;

/// Width and degree of the local fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LocalPolynomialSettings {
    /// Degree of the polynomials of response and leakage; 2 is usual.
    pub degree: usize,
    /// Lines on each side of the estimated one; at least `degree + 1`, so that the fit is determined. More
    /// lines average more noise.
    pub half_width: usize,
}

impl Default for LocalPolynomialSettings {
    fn default() -> Self {
        Self { degree: 2, half_width: 6 }
    }
}

/// Response at each line between two frequencies from one record, with leakage removed.
///
/// # Errors
/// [`LtiError::RecordLengths`], [`LtiError::RecordTooShort`], [`LtiError::NotFinite`];
/// [`LtiError::OutOfRange`] for a fit that is too narrow; [`LtiError::NotExcited`] if input and leakage
/// cannot be separated.
pub fn local_polynomial(
    input: &[f64],
    output: &[f64],
    period_s: f64,
    settings: &LocalPolynomialSettings,
    (low_hz, high_hz): (f64, f64),
) -> Result<ResponseEstimate, LtiError> {
    require_pair(input, output, period_s)?;
    let LocalPolynomialSettings { degree, half_width } = *settings;
    let (unknowns, equations) = (2 * (degree + 1), 2 * half_width + 1);
    if equations <= unknowns {
        return Err(LtiError::OutOfRange {
            quantity: "half width (lines)",
            value: half_width as f64,
            range: "[degree + 1, inf)",
        });
    }
    let n = input.len();
    require_samples(2 * equations + 2, n)?;
    let (u, y) = (transform(input), transform(output));
    let last = u.len() - 1;
    let mut estimate = ResponseEstimate::default();
    for line in 1..last {
        let frequency_hz = line as f64 / (n as f64 * period_s);
        if !(low_hz..=high_hz).contains(&frequency_hz) {
            continue;
        }
        // At the ends of the band the neighbours are on one side only.
        let first = line.saturating_sub(half_width).clamp(1, last - equations);
        let offset = |row: usize| ((first + row) as f64 - line as f64) / half_width as f64;
        let scale = (first..first + equations).map(|k| u[k].norm()).fold(0.0, f64::max);
        if scale <= 0.0 {
            return Err(LtiError::NotExcited { frequency_hz });
        }
        let regressors = DMatrix::from_fn(equations, unknowns, |row, column| {
            let power = offset(row).powf((column / 2) as f64);
            if column % 2 == 0 { u[first + row] / scale * power } else { C64::new(power, 0.0) }
        });
        let observed = DVector::from_fn(equations, |row, _| y[first + row]);
        let decomposition = regressors.clone().qr();
        let (q, r) = (decomposition.q(), decomposition.r());
        let Some(r_inverse) = r.try_inverse() else { return Err(LtiError::NotExcited { frequency_hz }) };
        let solution = &r_inverse * (q.adjoint() * &observed);
        let residual = (observed - regressors * &solution).norm_squared() / (equations - unknowns) as f64;
        estimate.frequencies_hz.push(frequency_hz);
        estimate.response.push(solution[0] / scale);
        estimate.variance.push(residual * r_inverse.row(0).norm_squared() / (scale * scale));
        estimate.degrees_of_freedom.push(2.0 * (equations - unknowns) as f64);
    }
    Ok(estimate)
}
