//! Separates noise from nonlinear distortion by random-phase multisines.
//!
//! Source: Pintelon and Schoukens, System Identification: A Frequency Domain Approach (2nd ed.), chapter 4:
//! the robust method (several realisations) and the fast method (detection lines). Wiley and IEEE Press,
//! 2012.

use super::estimate::ResponseEstimate;
use super::evidence::{ComplexDegrees, Evidence, evidence_beyond};
use super::periodic::{PeriodMeans, PeriodicRecord};
use crate::domain::C64;
use crate::error::LtiError;

/// One experiment: several periods of a multisine with its own random phases.
pub type Realisation<'a> = PeriodicRecord<'a>;

/// Best linear approximation with both of its uncertainties.
#[derive(Debug, Clone, PartialEq)]
pub struct BestLinearApproximation {
    /// The mean over realisations; its variance includes noise and nonlinear distortion.
    pub estimate: ResponseEstimate,
    /// Variance of the mean due to noise alone, at each frequency.
    pub noise_variance: Vec<f64>,
    /// Variance of a single realisation due to nonlinear distortion, at each frequency. It is unbiased, so
    /// without distortion it is negative at about half of the frequencies.
    pub distortion_variance: Vec<f64>,
    /// Whether the realisations differ by more than the noise.
    pub evidence: Evidence,
}

/// Power, relative to the line's own, of the rounding of long simulations: smaller differences do not count.
const ROUNDING: f64 = 1e-18;
/// Power of rounding relative to the strongest line: rounding of the whole output appears at every line,
/// however weak.
const ROUNDING_OF_STRONGEST: f64 = 1e-24;

/// Power of the output at each line that may be rounding.
fn rounding(means: &PeriodMeans) -> impl Fn(usize) -> f64 {
    let strongest = means.output.iter().map(C64::norm_sqr).fold(0.0, f64::max);
    move |k| ROUNDING * means.output[k].norm_sqr() + ROUNDING_OF_STRONGEST * strongest
}

/// Best linear approximation from several realisations. Differences between periods are noise; further
/// differences between realisations are nonlinear distortion.
///
/// # Errors
/// [`LtiError::RecordTooShort`] for fewer than two realisations; the errors of [`super::periodic_response`]
/// for each.
pub fn best_linear_approximation(
    realisations: &[Realisation<'_>],
    lines: &[usize],
) -> Result<BestLinearApproximation, LtiError> {
    let count = realisations.len();
    if count < 2 {
        return Err(LtiError::RecordTooShort { needed: 2, found: count });
    }
    let means = realisations.iter().map(|r| r.means(lines)).collect::<Result<Vec<_>, _>>()?;
    let roundings: Vec<_> = means.iter().map(rounding).collect();
    let mut estimate = ResponseEstimate::default();
    let (mut noise_variance, mut distortion_variance, mut explained) = (Vec::new(), Vec::new(), Vec::new());
    for (k, &line) in lines.iter().enumerate() {
        let frequency_hz = realisations[0].frequency_hz(line);
        let each =
            means.iter().map(|m| m.response(k, frequency_hz)).collect::<Result<Vec<(C64, f64)>, _>>()?;
        let m = count as f64;
        let mean = each.iter().map(|(g, _)| g).sum::<C64>() / m;
        let total = each.iter().map(|(g, _)| (g - mean).norm_sqr()).sum::<f64>() / (m * (m - 1.0));
        let noise = each.iter().map(|(_, v)| v).sum::<f64>() / (m * m);
        estimate.frequencies_hz.push(frequency_hz);
        estimate.response.push(mean);
        estimate.variance.push(total);
        estimate.degrees_of_freedom.push(2.0 * (m - 1.0));
        noise_variance.push(noise);
        distortion_variance.push(m * (total - noise));
        let rounded = means.iter().zip(&roundings).map(|(of, rounding)| rounding(k) / of.input[k].norm_sqr());
        explained.push(noise + rounded.sum::<f64>() / (m * m));
    }
    let degrees = ComplexDegrees { total: count - 1, noise: means.iter().map(|m| m.periods - 1).sum() };
    let evidence = evidence_beyond(&estimate.variance, &explained, degrees)?;
    Ok(BestLinearApproximation { estimate, noise_variance, distortion_variance, evidence })
}

/// Number of lines without excitation, on each side of an excited one, that give the distortion there.
const BESIDE: usize = 3;
/// Smallest number of lines without excitation between the first and the last excited one, as a share of the
/// excited ones.
const LEAST_SHARE: f64 = 0.1;

/// Nonlinear distortion of one realisation.
#[derive(Debug, Clone, PartialEq)]
pub struct DistortionBeside {
    /// Variance of the response at each excited line; negative if the neighbouring lines hold less than the
    /// mean noise.
    pub variance: Vec<f64>,
    /// Whether the lines without excitation hold more than noise.
    pub evidence: Evidence,
}

/// Variance of the response at the excited lines due to nonlinear distortion, from the output beside them
/// (the fast method). One realisation is enough if its multisine omits lines. `None` if it omits too few.
///
/// # Errors
/// As [`super::periodic_response`].
pub fn distortion_beside(
    record: &PeriodicRecord<'_>,
    excited: &[usize],
) -> Result<Option<DistortionBeside>, LtiError> {
    let (Some(&first), Some(&last)) = (excited.first(), excited.last()) else { return Ok(None) };
    let lines: Vec<usize> = (first..=last).collect();
    let silent: Vec<usize> =
        lines.iter().copied().filter(|line| excited.binary_search(line).is_err()).collect();
    if (silent.len() as f64) < (LEAST_SHARE * excited.len() as f64).max(2.0 * BESIDE as f64) {
        return Ok(None);
    }
    let means = record.means(&lines)?;
    let variance = |&line: &usize| {
        let k = line - first;
        let (response, _) = means.response(k, record.frequency_hz(line))?;
        let after = silent.partition_point(|s| *s < line);
        let beside = &silent[after.saturating_sub(BESIDE)..(after + BESIDE).min(silent.len())];
        let power: f64 = beside.iter().map(|s| means.beyond(s - first, response)).sum();
        Ok(power / beside.len() as f64 / means.input[k].norm_sqr())
    };
    let variance = excited.iter().map(variance).collect::<Result<Vec<f64>, LtiError>>()?;
    let rounding = rounding(&means);
    let mut powers = [Vec::new(), Vec::new()];
    for line in silent {
        let nearest = excited[excited.partition_point(|l| *l < line).min(excited.len() - 1)] - first;
        let (response, _) = means.response(nearest, record.frequency_hz(first + nearest))?;
        let [total, noise] = means.left_and_noise(line - first, response);
        powers[0].push(total);
        powers[1].push(noise + rounding(nearest));
    }
    let evidence =
        evidence_beyond(&powers[0], &powers[1], ComplexDegrees { total: 1, noise: means.periods - 1 })?;
    Ok(Some(DistortionBeside { variance, evidence }))
}
