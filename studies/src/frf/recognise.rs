//! Recognises the excitation of a record's command, and chooses the estimator for it.

use feeler_analysis::AnalysisError;
use feeler_lti::LtiError;
use feeler_lti::spectral::{Estimator, RecordedExcitation, SineSum, find_sines, recognise_excitation};

use super::error::{FrfError, require};
use super::request::{ExcitationKind, FrfRequest, NoiseEstimator};
use crate::numbers::{plain, with_unit};
use crate::refusal::Refusal;

/// Default number of segments of averaged spectra.
pub const SEGMENTS: f64 = 8.0;
/// Sines of two records are equal if their frequencies differ by less than this share of the inverse of the
/// record's length.
const SAME_LINE: f64 = 0.25;
/// Share of the power from which one sine alone is the excitation. The others may be responses of the
/// controller.
const NEARLY_ALL: f64 = 0.9;

/// Command and output of one experiment, with their means subtracted.
pub type RecordPair = (Vec<f64>, Vec<f64>);

/// Method of evaluating records.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// Spectral lines of whole periods.
    Periodic { samples_per_period: usize },
    /// Sines fitted together, Hz.
    Sines(Vec<f64>),
    /// Polynomials through neighbouring lines.
    LocalPolynomial,
    /// Averages over segments of this many seconds.
    Averaged {
        /// H1, H2 or Hv.
        kind: Estimator,
        /// Length of a segment, s.
        segment_s: f64,
    },
    /// Averages over neighbouring lines.
    Smoothed(Estimator),
}

/// A method, and the reason for it if it was not requested.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodChoice {
    pub method: Method,
    /// The reason, in words.
    pub why: Option<String>,
}

impl Method {
    /// Whether the method uses only the excited frequencies.
    pub fn is_of_lines(&self) -> bool {
        matches!(self, Self::Periodic { .. } | Self::Sines(_))
    }
}

/// The requested method, or else the one that suits the excitation of the commands.
///
/// # Errors
/// A request that the records cannot meet.
pub fn choose(
    request: &FrfRequest,
    pairs: &[RecordPair],
    spacing_s: f64,
    length_s: f64,
) -> Result<MethodChoice, FrfError> {
    let averaged =
        |kind| Method::Averaged { kind, segment_s: request.segment_s.unwrap_or(length_s / SEGMENTS) };
    let kind = request.estimator.map(NoiseEstimator::averaged);
    let asked = request.excitation.or(request.period_s.map(|_| ExcitationKind::Multisine));
    let asked = asked
        .or(kind.map(|_| ExcitationKind::WhiteNoise))
        .or(request.segment_s.map(|_| ExcitationKind::WhiteNoise));
    let method = match asked {
        None => {
            return Ok(recognise(pairs, spacing_s, length_s).map_err(AnalysisError::from)?);
        }
        Some(ExcitationKind::SteppedSine) => {
            return Err(Refusal::new(
                "records of a stepped sine cannot be evaluated: they do not show where each frequency begins",
                "leave --excitation out to find the sines of the record, or to average its spectra",
            )
            .into());
        }
        Some(ExcitationKind::Multisine) => {
            require(
                request.estimator.is_none(),
                || "--estimator has no meaning for a multisine".to_owned(),
                "leave it out",
            )?;
            let Some(period_s) = request.period_s else {
                return Err(Refusal::new(
                    "the period of a measured multisine must be known",
                    "give it with --period, in s, or leave --excitation out to find a period in the command",
                )
                .into());
            };
            let samples_per_period = (period_s / spacing_s).round() as usize;
            let shortest = pairs.iter().map(|(u, _)| u.len()).min().unwrap_or(0);
            require(
                samples_per_period >= 4 && shortest / samples_per_period >= 2,
                || {
                    format!(
                        "records of {} are shorter than two periods of {}",
                        with_unit(length_s, "s"),
                        with_unit(period_s, "s")
                    )
                },
                "the noise estimate needs two periods; leave --period out to find the sines of the record",
            )?;
            Method::Periodic { samples_per_period }
        }
        Some(ExcitationKind::Chirp) => Method::Smoothed(kind.flatten().unwrap_or_default()),
        Some(ExcitationKind::WhiteNoise) => match kind.flatten() {
            Some(kind) => averaged(kind),
            None if pairs.len() > 1 || request.segment_s.is_some() => {
                require(
                    request.estimator != Some(NoiseEstimator::LocalPolynomial),
                    || {
                        "local polynomials need one whole record: they average no records and no segments"
                            .to_owned()
                    },
                    "name one --experiment and no --segment, or an estimator that averages: h1, h2 or hv",
                )?;
                averaged(Estimator::H1)
            }
            None => Method::LocalPolynomial,
        },
    };
    request.require_segments(matches!(method, Method::Averaged { .. }))?;
    Ok(MethodChoice { method, why: None })
}

/// The method for the excitation of the first command, if all commands have the same excitation.
fn recognise(pairs: &[RecordPair], spacing_s: f64, length_s: f64) -> Result<MethodChoice, LtiError> {
    let averaged = || Method::Averaged { kind: Estimator::H1, segment_s: length_s / SEGMENTS };
    let chosen = |method, why: String| Ok(MethodChoice { method, why: Some(why) });
    let all = pairs
        .iter()
        .map(|(command, _)| recognise_excitation(command, spacing_s))
        .collect::<Result<Vec<_>, _>>()?;
    let Some(first) = all.first() else { return Err(LtiError::RecordTooShort { needed: 1, found: 0 }) };
    match first {
        RecordedExcitation::Periodic { samples_per_period, periods } => {
            let alike = |other: &RecordedExcitation| match other {
                RecordedExcitation::Periodic { samples_per_period: n, .. } => n == samples_per_period,
                _ => false,
            };
            if all.iter().all(alike) {
                let period = with_unit(*samples_per_period as f64 * spacing_s, "s");
                let why = format!(
                    "the command repeats every {period}, {periods} times: its lines are evaluated over \
                     whole periods"
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
                        "; {} weak overtones of the strongest sine are left out, since a controller that \
                         counters friction produces such overtones",
                        overtones.len()
                    )
                };
                let why = format!(
                    "{} % of the command's power are sines without a common period that repeats: they are \
                     fitted together, and only their frequencies are evaluated{but}",
                    plain((1e3 * sines.explained).floor() / 10.0)
                );
                return chosen(Method::Sines(common), why);
            }
        }
        RecordedExcitation::Noise { evenness } if pairs.len() == 1 => {
            let why = format!(
                "the command is noise with power in its whole band (evenness {}): leakage is estimated \
                 together with the response",
                plain(*evenness)
            );
            return chosen(Method::LocalPolynomial, why);
        }
        RecordedExcitation::Sweep if all.iter().all(|other| *other == RecordedExcitation::Sweep) => {
            let why =
                "the command's spectrum is even and smooth, as that of a chirp: spectra are averaged over \
                 neighbouring lines"
                    .to_owned();
            return chosen(Method::Smoothed(Estimator::H1), why);
        }
        RecordedExcitation::Uneven { evenness } => {
            let why = format!(
                "the command is neither sines nor even noise (evenness {}): windowed segments are averaged, \
                 so that strong frequencies do not leak into weak ones",
                plain(*evenness)
            );
            return chosen(averaged(), why);
        }
        _ => {}
    }
    chosen(averaged(), "several records are averaged, segment by segment".to_owned())
}

/// Frequencies of the weak sines at multiples of a sine with nearly all the power, Hz.
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
