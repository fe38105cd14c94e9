//! Which estimator suits a record, and what it gives.

use feeler_analysis::frf::{NoiseMethod, response_from_noise};
use feeler_lti::LtiError;
use feeler_lti::spectral::{
    CrossSpectra, Estimator, LocalPolynomialSettings, Realisation, RecordedExcitation, ResponseEstimate,
    SineSum, WelchSettings, best_linear_approximation, cross_spectra, distortion_beside, excited_lines,
    find_sines, periodic_response, recognise_excitation, response_at_sines, smoothed_spectra,
};

use super::{ToldApart, estimator, refused, require, require_segments};
use crate::arguments::{EstimatorKind, ExcitationKind, Frf};
use crate::numbers::{plain, with_unit};
use crate::terminal::failure::BadInput;

/// Segments of which averaged spectra are formed where no length is given.
pub(super) const SEGMENTS: f64 = 8.0;
/// Lines on each side over which the spectra of a chirp are averaged.
const HALF_WIDTH: usize = 1;
/// Sines of two records are the same where they differ by less than this share of one over the record's
/// length.
const SAME_LINE: f64 = 0.25;

/// Share of the power from which on one sine is what the machine was moved with, and the others may be
/// answers of its controller.
const NEARLY_ALL: f64 = 0.9;

/// Command and output of one experiment, about their means.
pub(super) type Pair = (Vec<f64>, Vec<f64>);

/// How records are evaluated.
pub(super) enum Method {
    /// Lines of whole periods.
    Periodic { samples_per_period: usize },
    /// Sines fitted together, Hz.
    Sines(Vec<f64>),
    /// Polynomials through neighbouring lines.
    LocalPolynomial,
    /// Averages over segments of so many seconds.
    Averaged { kind: Estimator, segment_s: f64 },
    /// Averages over neighbouring lines.
    Smoothed(Estimator),
}

/// A method and why it was chosen, where it was not asked for.
pub(super) struct Choice {
    pub(super) method: Method,
    pub(super) why: Option<String>,
}

/// What records give.
pub(super) struct Evaluated {
    pub(super) estimate: ResponseEstimate,
    pub(super) told_apart: Option<ToldApart>,
    pub(super) how: String,
    /// Whether there is nothing to be known between the frequencies.
    pub(super) isolated: bool,
}

impl Method {
    /// Whether the method itself looks at excited frequencies alone.
    pub(super) fn is_of_lines(&self) -> bool {
        matches!(self, Self::Periodic { .. } | Self::Sines(_))
    }
}

/// The method that was asked for, else the one that suits how the commands were made.
pub(super) fn choose(
    arguments: &Frf,
    pairs: &[Pair],
    spacing_s: f64,
    length_s: f64,
) -> anyhow::Result<Choice> {
    let averaged =
        |kind| Method::Averaged { kind, segment_s: arguments.segment.unwrap_or(length_s / SEGMENTS) };
    let kind = arguments.estimator.map(estimator);
    let asked = arguments.excitation.or(arguments.period.map(|_| ExcitationKind::Multisine));
    let asked = asked
        .or(kind.map(|_| ExcitationKind::WhiteNoise))
        .or(arguments.segment.map(|_| ExcitationKind::WhiteNoise));
    let method = match asked {
        None => {
            return recognise(pairs, spacing_s, length_s).map_err(|error| refused(arguments, &error.into()));
        }
        Some(ExcitationKind::SteppedSine) => {
            return Err(BadInput::error(
                "a stepped sine is not evaluated from records: they do not say where each frequency begins",
                "leave --excitation out: the record's sines are found, or its spectra averaged",
            ));
        }
        Some(ExcitationKind::Multisine) => {
            require(
                arguments.estimator.is_none(),
                || "--estimator has no meaning for a multisine".to_owned(),
                "leave it out",
            )?;
            let Some(period_s) = arguments.period else {
                return Err(BadInput::error(
                    "the period of a measured multisine must be known",
                    "give it with --period, in s, or leave --excitation out: a period is sought in the command",
                ));
            };
            let samples_per_period = (period_s / spacing_s).round() as usize;
            let shortest = pairs.iter().map(|(u, _)| u.len()).min().unwrap_or(0);
            require(
                samples_per_period >= 4 && shortest / samples_per_period >= 2,
                || {
                    format!(
                        "records of {} hold no two periods of {}",
                        with_unit(length_s, "s"),
                        with_unit(period_s, "s")
                    )
                },
                "two periods are needed to tell noise; leave --period out, and the record's sines are sought",
            )?;
            Method::Periodic { samples_per_period }
        }
        Some(ExcitationKind::Chirp) => Method::Smoothed(kind.flatten().unwrap_or_default()),
        Some(ExcitationKind::WhiteNoise) => match kind.flatten() {
            Some(kind) => averaged(kind),
            None if pairs.len() > 1 || arguments.segment.is_some() => {
                require(
                    arguments.estimator != Some(EstimatorKind::LocalPolynomial),
                    || {
                        "local polynomials take one whole record: they average neither several nor segments"
                            .to_owned()
                    },
                    "name one --experiment and no --segment, or an estimator that averages: h1, h2 or hv",
                )?;
                averaged(Estimator::H1)
            }
            None => Method::LocalPolynomial,
        },
    };
    require_segments(arguments, matches!(method, Method::Averaged { .. }))?;
    Ok(Choice { method, why: None })
}

/// The method for how the first command was made, if the others were made alike.
fn recognise(pairs: &[Pair], spacing_s: f64, length_s: f64) -> Result<Choice, LtiError> {
    let averaged = || Method::Averaged { kind: Estimator::H1, segment_s: length_s / SEGMENTS };
    let chosen = |method, why: String| Ok(Choice { method, why: Some(why) });
    let all = pairs
        .iter()
        .map(|(command, _)| recognise_excitation(command, spacing_s))
        .collect::<Result<Vec<_>, _>>()?;
    let Some(first) = all.first() else { return Err(LtiError::RecordTooShort { needed: 1, found: 0 }) };
    match first {
        RecordedExcitation::Periodic { samples_per_period, periods } => {
            let alike = |other: &RecordedExcitation| matches!(other, RecordedExcitation::Periodic { samples_per_period: n, .. } if n == samples_per_period);
            if all.iter().all(alike) {
                let period = with_unit(*samples_per_period as f64 * spacing_s, "s");
                let why = format!(
                    "the command repeats every {period}, {periods} times: its lines are evaluated over whole periods"
                );
                return chosen(Method::Periodic { samples_per_period: *samples_per_period }, why);
            }
        }
        RecordedExcitation::Sines(sines) => {
            let overtones = overtones(sines, length_s);
            let mut common: Vec<f64> =
                sines.frequencies_hz.iter().copied().filter(|f| !overtones.contains(f)).collect();
            let made = common.len();
            for (command, _) in &pairs[1..] {
                let others = find_sines(command, spacing_s)?.frequencies_hz;
                common.retain(|f| others.iter().any(|other| (other - f).abs() * length_s < SAME_LINE));
            }
            if 2 * common.len() > made {
                let but = if overtones.is_empty() {
                    String::new()
                } else {
                    format!(
                        "; {} weak overtones of the strongest are not, since a controller that answers friction makes such",
                        overtones.len()
                    )
                };
                let why = format!(
                    "sines of which no common period is seen twice make up {} % of the command's power: they are fitted together, and only their \
                     frequencies are evaluated{but}",
                    plain((1e3 * sines.explained).floor() / 10.0)
                );
                return chosen(Method::Sines(common), why);
            }
        }
        RecordedExcitation::Noise { evenness } if pairs.len() == 1 => {
            let why = format!(
                "the command is noise with power all over its band (evenness {}): leakage is estimated along with the response",
                plain(*evenness)
            );
            return chosen(Method::LocalPolynomial, why);
        }
        RecordedExcitation::Sweep if all.iter().all(|other| *other == RecordedExcitation::Sweep) => {
            let why =
                "the command's spectrum is even and smooth, as that of a chirp: spectra are averaged over neighbouring lines".to_owned();
            return chosen(Method::Smoothed(Estimator::H1), why);
        }
        RecordedExcitation::Uneven { evenness } => {
            let why = format!(
                "the command is neither sines nor even noise (evenness {}): windowed segments are averaged, so that its strong frequencies do not leak \
                 into the weak ones",
                plain(*evenness)
            );
            return chosen(averaged(), why);
        }
        _ => {}
    }
    chosen(averaged(), "several records are averaged, segment by segment".to_owned())
}

/// Weak sines at multiples of one that has nearly all the power, Hz.
fn overtones(sines: &SineSum, length_s: f64) -> Vec<f64> {
    let power: f64 = sines.amplitudes.iter().map(|a| a * a).sum();
    let strongest =
        (0..sines.amplitudes.len()).max_by(|&i, &j| sines.amplitudes[i].total_cmp(&sines.amplitudes[j]));
    let Some(fundamental) = strongest.filter(|&i| sines.amplitudes[i].powi(2) > NEARLY_ALL * power) else {
        return Vec::new();
    };
    let base_hz = sines.frequencies_hz[fundamental];
    let is_multiple = |f: &f64| {
        f / base_hz > 1.5 && (f - (f / base_hz).round() * base_hz).abs() * length_s < 2.0 * SAME_LINE
    };
    sines.frequencies_hz.iter().copied().filter(is_multiple).collect()
}

/// The response by a method, between two frequencies (Hz).
pub(super) fn evaluate(
    choice: &Choice,
    pairs: &[Pair],
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
                told_apart: None,
                how: "local polynomials (leakage taken away)".to_owned(),
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
            Ok(Evaluated { estimate, told_apart: None, how, isolated: false })
        }
        Method::Smoothed(kind) => {
            let spectra = pairs
                .iter()
                .map(|(u, y)| smoothed_spectra(u, y, spacing_s, HALF_WIDTH))
                .collect::<Result<Vec<_>, _>>()?;
            let estimate = CrossSpectra::averaged(&spectra)?.response(*kind, band_hz.0, band_hz.1)?;
            Ok(Evaluated { estimate, told_apart: None, how: format!("chirp, {kind:?}"), isolated: false })
        }
    }
}

fn periodic(
    pairs: &[Pair],
    spacing_s: f64,
    samples_per_period: usize,
    band_hz: (f64, f64),
) -> Result<Evaluated, LtiError> {
    let shortest = pairs.iter().map(|(u, _)| u.len()).min().unwrap_or(0);
    let periods = shortest / samples_per_period;
    // The first period holds the transient, where there are others.
    let transient_periods = usize::from(periods > 2);
    let whole = periods * samples_per_period;
    let realisation = |(u, y): &'_ Pair| (u[..whole].to_vec(), y[..whole].to_vec());
    let cut: Vec<Pair> = pairs.iter().map(realisation).collect();
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
        // Distortion repeats with the period, and moves the estimate as much as noise does.
        if let Some(found) = &distortion {
            estimate
                .variance
                .iter_mut()
                .zip(&found.variance)
                .for_each(|(variance, distortion)| *variance += distortion.max(0.0));
        }
        let told_apart =
            distortion.map(|found| ToldApart { noise, distortion: found.variance, evidence: found.evidence });
        return Ok(Evaluated { estimate, told_apart, how, isolated });
    }
    let best = best_linear_approximation(&realisations, &lines)?;
    let count = realisations.len() as f64;
    let noise = best.noise_variance.into_iter().map(|v| v * count).collect();
    let told_apart = ToldApart { noise, distortion: best.distortion_variance, evidence: best.evidence };
    Ok(Evaluated { estimate: best.estimate, told_apart: Some(told_apart), how, isolated })
}

fn sines(
    pairs: &[Pair],
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
        // Records that differ by more than each is uncertain differ by nonlinearity.
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
    Ok(Evaluated { estimate, told_apart: None, how, isolated: true })
}
