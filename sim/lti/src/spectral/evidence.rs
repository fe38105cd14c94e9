//! Tests whether a variance exceeds the noise significantly.

use crate::error::LtiError;

/// Standard deviations by which a mean over lines must exceed that of noise alone: the chance is one in 740.
const DEVIATIONS: f64 = 3.0;
/// Chance that noise alone gives at least one line, among all, with such an excess.
const CHANCE: f64 = 1e-3;

/// Half the degrees of freedom of the variances of complex values: the number of independent complex
/// differences.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ComplexDegrees {
    /// Degrees of the variance that may hold more than noise.
    pub total: usize,
    /// Degrees of the variance of the noise.
    pub noise: usize,
}

/// Result of the test of a variance against the noise, over all lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Whether there is more than noise: the mean over lines, or a single line, exceeds it significantly.
    pub is_beyond_noise: bool,
    /// The smallest detectable excess on all lines, relative to the noise.
    pub least_share: f64,
    /// Degrees of freedom of the variances.
    pub degrees: ComplexDegrees,
    /// Number of lines that were tested.
    pub lines: usize,
}

/// Tests whether variances exceed those of the noise; lines are independent of each other.
///
/// Without excess each ratio follows an F distribution. The mean of its logarithm is ψ(a) - ln a - ψ(b) + ln
/// b and its variance ψ'(a) + ψ'(b). Here a and b are the complex degrees of freedom. A single line is tested
/// against the tail of F. Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 6.3.2, 6.4.3 and
/// 26.6.2 (1964).
///
/// # Errors
/// [`LtiError::RecordTooShort`] without lines or degrees of freedom.
pub(crate) fn evidence_beyond(
    total: &[f64],
    noise: &[f64],
    degrees: ComplexDegrees,
) -> Result<Evidence, LtiError> {
    let (a, b) = (degrees.total, degrees.noise);
    let least = total.len().min(noise.len()).min(a).min(b);
    if least == 0 {
        return Err(LtiError::RecordTooShort { needed: 1, found: least });
    }
    let lines = total.len() as f64;
    let ratios = || total.iter().zip(noise).map(|(t, n)| t.max(f64::MIN_POSITIVE) / n.max(f64::MIN_POSITIVE));
    let bias = log_bias(a) - log_bias(b);
    let deviation = ((trigamma(a) + trigamma(b)) / lines).sqrt();
    let excess = ratios().map(f64::ln).sum::<f64>() / lines - bias;
    let rarest = ratios().map(|ratio| tail(ratio, a, b)).fold(1.0, f64::min);
    Ok(Evidence {
        is_beyond_noise: excess > DEVIATIONS * deviation || rarest * lines < CHANCE,
        least_share: (DEVIATIONS * deviation).exp_m1(),
        degrees,
        lines: total.len(),
    })
}

/// ψ(n) - ln n.
fn log_bias(n: usize) -> f64 {
    const EULER: f64 = 0.577_215_664_901_532_9;
    (1..n).map(|k| 1.0 / k as f64).sum::<f64>() - EULER - (n as f64).ln()
}

/// ψ'(n).
fn trigamma(n: usize) -> f64 {
    std::f64::consts::PI.powi(2) / 6.0 - (1..n).map(|k| (k as f64).powi(-2)).sum::<f64>()
}

/// Chance that a ratio with an F distribution of 2a and 2b degrees of freedom exceeds a value.
fn tail(ratio: f64, a: usize, b: usize) -> f64 {
    let x = 1.0 / (1.0 + a as f64 / b as f64 * ratio);
    // x^b sum over i < a of (b)_i / i! (1 - x)^i.
    let mut term = 1.0;
    let mut sum = 1.0;
    for i in 1..a {
        term *= (b + i - 1) as f64 / i as f64 * (1.0 - x);
        sum += term;
    }
    x.powf(b as f64) * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_tail_of_f() {
        // 95 % quantiles of F(6, 24), F(2, 6) and F(4, 10) in the usual tables, to their digits.
        for (quantile, a, b) in [(2.508_2, 3, 12), (5.143_3, 1, 3), (3.478_0, 2, 5)] {
            assert!((tail(quantile, a, b) - 0.05).abs() < 1e-5, "{quantile}");
        }
    }

    #[test]
    fn truth_one_line_is_enough_and_an_even_share_is_too() {
        let degrees = ComplexDegrees { total: 3, noise: 12 };
        let typical = log_bias(3) - log_bias(12);
        let level = |excess: f64| (typical + excess).exp();
        let noise = vec![1.0; 100];
        let of = |total: &[f64]| evidence_beyond(total, &noise, degrees).unwrap();
        let mut total = vec![level(0.0); 100];
        let quiet = of(&total);
        assert!(!quiet.is_beyond_noise);
        let least = quiet.least_share.ln_1p();
        assert!(
            !of(&vec![level(0.99 * least); 100]).is_beyond_noise
                && of(&vec![level(1.01 * least); 100]).is_beyond_noise
        );
        total[40] = 20.0;
        assert!(of(&total).is_beyond_noise);
        assert!(evidence_beyond(&[], &[], degrees).is_err());
    }
}
