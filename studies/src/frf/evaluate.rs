//! The response from records by a method.

use feeler_analysis::frf::{NoiseMethod, response_from_noise};
use feeler_lti::LtiError;
use feeler_lti::spectral::{
    CrossSpectra, LocalPolynomialSettings, Realisation, ResponseEstimate, WelchSettings,
    best_linear_approximation, cross_spectra, distortion_beside, excited_lines, periodic_response,
    response_at_sines, smoothed_spectra,
};

use super::distortion::Separated;
use super::recognise::{Method, MethodChoice, RecordPair};
use crate::numbers::with_unit;

/// Lines on each side over which the spectra of a chirp are averaged.
const HALF_WIDTH: usize = 1;

/// Result of evaluated records.
#[derive(Clone, Debug)]
pub struct Evaluated {
    pub estimate: ResponseEstimate,
    /// Noise and distortion, if the excitation separates them.
    pub separated: Option<Separated>,
    /// Estimator and records in words.
    pub how: String,
    /// Whether the estimate has no values between its frequencies.
    pub isolated: bool,
}

/// The response by a method, between two frequencies (Hz).
///
/// # Errors
/// If the records are too short for the method.
pub fn evaluate(
    choice: &MethodChoice,
    pairs: &[RecordPair],
    spacing_s: f64,
    band_hz: (f64, f64),
) -> Result<Evaluated, feeler_analysis::AnalysisError> {
    match &choice.method {
        Method::Periodic { samples_per_period } => {
            Ok(periodic(pairs, spacing_s, *samples_per_period, band_hz)?)
        }
        Method::Sines(frequencies_hz) => Ok(sines(pairs, spacing_s, frequencies_hz, band_hz)?),
        Method::LocalPolynomial => {
            let (u, y) = &pairs[0];
            let method = NoiseMethod::LocalPolynomial(LocalPolynomialSettings::default());
            let estimate = response_from_noise(u, y, spacing_s, method, band_hz)?;
            Ok(Evaluated {
                estimate,
                separated: None,
                how: "local polynomials (leakage removed)".to_owned(),
                isolated: false,
            })
        }
        Method::Averaged { kind, segment_s } => {
            let settings = WelchSettings::hann((segment_s / spacing_s).round() as usize);
            let spectra = pairs
                .iter()
                .map(|(u, y)| cross_spectra(u, y, spacing_s, &settings))
                .collect::<Result<Vec<_>, _>>()?;
            let estimate = CrossSpectra::averaged(&spectra)?.response(*kind, band_hz.0, band_hz.1)?;
            let how = format!("{kind:?} of segments of {}", with_unit(*segment_s, "s"));
            Ok(Evaluated { estimate, separated: None, how, isolated: false })
        }
        Method::Smoothed(kind) => {
            let spectra = pairs
                .iter()
                .map(|(u, y)| smoothed_spectra(u, y, spacing_s, HALF_WIDTH))
                .collect::<Result<Vec<_>, _>>()?;
            let estimate = CrossSpectra::averaged(&spectra)?.response(*kind, band_hz.0, band_hz.1)?;
            Ok(Evaluated { estimate, separated: None, how: format!("chirp, {kind:?}"), isolated: false })
        }
    }
}

fn periodic(
    pairs: &[RecordPair],
    spacing_s: f64,
    samples_per_period: usize,
    band_hz: (f64, f64),
) -> Result<Evaluated, LtiError> {
    let shortest = pairs.iter().map(|(u, _)| u.len()).min().unwrap_or(0);
    let periods = shortest / samples_per_period;
    // If there are others, the first period contains the transient.
    let transient_periods = usize::from(periods > 2);
    let whole = periods * samples_per_period;
    let realisation = |(u, y): &'_ RecordPair| (u[..whole].to_vec(), y[..whole].to_vec());
    let cut: Vec<RecordPair> = pairs.iter().map(realisation).collect();
    let realisations: Vec<Realisation<'_>> = (cut.iter())
        .map(|(input, output)| Realisation {
            input,
            output,
            period_s: spacing_s,
            samples_per_period,
            transient_periods,
        })
        .collect();
    let lines = excited_lines(&realisations[0], band_hz)?;
    let period_s = samples_per_period as f64 * spacing_s;
    let records =
        if realisations.len() > 1 { format!(", {} realisations", realisations.len()) } else { String::new() };
    let how = format!("lines of {periods} periods of {}{records}", with_unit(period_s, "s"));
    let isolated = lines.windows(2).any(|pair| pair[1] - pair[0] > 2);
    if let [only] = realisations.as_slice() {
        let mut estimate = periodic_response(only, &lines)?;
        let distortion = distortion_beside(only, &lines)?;
        let noise = estimate.variance.clone();
        // Distortion repeats with the period, and changes the estimate as much as noise does.
        if let Some(found) = &distortion {
            estimate
                .variance
                .iter_mut()
                .zip(&found.variance)
                .for_each(|(variance, distortion)| *variance += distortion.max(0.0));
        }
        let separated =
            distortion.map(|found| Separated { noise, distortion: found.variance, evidence: found.evidence });
        return Ok(Evaluated { estimate, separated, how, isolated });
    }
    let best = best_linear_approximation(&realisations, &lines)?;
    let count = realisations.len() as f64;
    let noise = best.noise_variance.into_iter().map(|v| v * count).collect();
    let separated = Separated { noise, distortion: best.distortion_variance, evidence: best.evidence };
    Ok(Evaluated { estimate: best.estimate, separated: Some(separated), how, isolated })
}

fn sines(
    pairs: &[RecordPair],
    spacing_s: f64,
    frequencies_hz: &[f64],
    (low_hz, high_hz): (f64, f64),
) -> Result<Evaluated, LtiError> {
    let each = pairs
        .iter()
        .map(|(u, y)| response_at_sines(u, y, spacing_s, frequencies_hz))
        .collect::<Result<Vec<_>, _>>()?;
    let count = each.len() as f64;
    let mut estimate = each[0].clone();
    for k in 0..frequencies_hz.len() {
        let mean = each.iter().map(|one| one.response[k]).sum::<feeler_lti::C64>() / count;
        let within = each.iter().map(|one| one.variance[k]).sum::<f64>() / (count * count);
        let spread = each.iter().map(|one| (one.response[k] - mean).norm_sqr()).sum::<f64>()
            / (count * (count - 1.0)).max(1.0);
        estimate.response[k] = mean;
        // Differences between records beyond the uncertainty of each come from nonlinearity.
        estimate.variance[k] = within.max(spread);
        estimate.degrees_of_freedom[k] = each.iter().map(|one| one.degrees_of_freedom[k]).sum();
        if let Some(coherence) = &mut estimate.coherence {
            coherence[k] = 1.0 / (1.0 + count * within / mean.norm_sqr().max(f64::MIN_POSITIVE));
        }
    }
    let records = if each.len() > 1 { format!(", mean of {} records", each.len()) } else { String::new() };
    let estimate = estimate.within(low_hz, high_hz);
    let how = format!(
        "sum of sines, {} of them in the band, fitted to the whole record, Hann-weighted{records}",
        estimate.response.len()
    );
    Ok(Evaluated { estimate, separated: None, how, isolated: true })
}
