//! Options of a frequency response.

use feeler_control::{Law, ReferenceSpec};
use feeler_engine::{ControllerUse, Scenario};
use feeler_lti::spectral::Estimator;
use feeler_plant::description::{Engagement, Quantity, SignalName};

use super::error::require;
use crate::refusal::Refusal;

/// A requested frequency response; absent options follow from the machine or the records.
#[derive(Clone, Debug, PartialEq)]
pub struct FrfRequest {
    /// The actuator's command, or a dataset's column.
    pub input: Option<String>,
    /// The signal, or a dataset's column.
    pub output: Option<String>,
    pub excitation: Option<ExcitationKind>,
    pub estimator: Option<NoiseEstimator>,
    /// Lowest frequency, Hz.
    pub from_hz: Option<f64>,
    /// Highest frequency, Hz.
    pub to_hz: Option<f64>,
    /// Root mean square of the excitation, in the unit of the command.
    pub rms: Option<f64>,
    /// Mean of the command, in its unit.
    pub offset: Option<f64>,
    /// Length of noise or chirp, s.
    pub duration_s: Option<f64>,
    /// Length of the segments of noise that are averaged, s.
    pub segment_s: Option<f64>,
    /// Period of a multisine, s.
    pub period_s: Option<f64>,
    /// Number of evaluated periods of the multisine.
    pub periods: Option<usize>,
    /// Number of phase realisations of the multisine.
    pub realisations: Option<usize>,
    /// Frequencies of the stepped sine.
    pub points: Option<usize>,
    /// Time for which each command is held, s.
    pub hold_s: Option<f64>,
    /// Seed of excitation and noise.
    pub seed: Option<u64>,
    /// Engagement of every contact.
    pub engagement: Option<Engagement>,
    /// Confidence of the bands, between 0 and 1.
    pub confidence: f64,
    /// Records of a dataset by name; by default the first one.
    pub experiments: Vec<String>,
}

impl Default for FrfRequest {
    fn default() -> Self {
        Self {
            input: None,
            output: None,
            excitation: None,
            estimator: None,
            from_hz: None,
            to_hz: None,
            rms: None,
            offset: None,
            duration_s: None,
            segment_s: None,
            period_s: None,
            periods: None,
            realisations: None,
            points: None,
            hold_s: None,
            seed: None,
            engagement: None,
            confidence: 0.95,
            experiments: Vec::new(),
        }
    }
}

/// The excitation of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExcitationKind {
    /// Band-limited Gaussian noise.
    WhiteNoise,
    /// Multisines of random phase: noise and nonlinear distortion are separated.
    Multisine,
    /// A linear chirp and silence after it.
    Chirp,
    /// One sine after the other.
    SteppedSine,
}

/// The estimator for records of noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseEstimator {
    /// Polynomials through neighbouring lines of the whole record; these estimate the leakage as well.
    LocalPolynomial,
    /// Averaged spectra.
    Averaged(Estimator),
}

impl NoiseEstimator {
    /// The estimator of averaged spectra; absent for local polynomials.
    pub fn averaged(self) -> Option<Estimator> {
        match self {
            Self::LocalPolynomial => None,
            Self::Averaged(estimator) => Some(estimator),
        }
    }
}

impl FrfRequest {
    /// This request with the multisine that the file itself applies to the input, unless it asks for another
    /// excitation.
    #[must_use]
    pub fn excited_as(self, scenario: &Scenario) -> Self {
        let has_own = self.excitation.is_some()
            || self.estimator.is_some()
            || self.duration_s.or(self.segment_s).is_some()
            || self.points.is_some();
        let is_input = |used: &&ControllerUse| {
            let command = SignalName::new(&used.drives, Quantity::Command).to_string();
            self.input.as_ref().is_none_or(|input| [&used.drives, &command].contains(&input))
        };
        let spec = scenario.controllers.values().find(is_input).map(|used| &used.spec);
        let played = spec.filter(|spec| !has_own && matches!(spec.law, Law::OpenLoop));
        let Some(&ReferenceSpec::Multisine { low_hz, high_hz, period_s, rms, offset, .. }) =
            played.map(|spec| &spec.reference)
        else {
            return self;
        };
        Self {
            excitation: Some(ExcitationKind::Multisine),
            from_hz: self.from_hz.or(Some(low_hz)),
            to_hz: self.to_hz.or(Some(high_hz)),
            rms: self.rms.or(Some(rms)),
            offset: self.offset.or(Some(offset)),
            period_s: self.period_s.or(Some(period_s)),
            ..self
        }
    }

    /// The band that is evaluated, Hz, for samples that come every `hold_s`.
    ///
    /// # Errors
    /// A band that is empty or beyond half the sampling rate, or a confidence that is not a probability.
    pub fn band(&self, hold_s: f64, lowest_hz: f64, excited_hz: Option<f64>) -> Result<(f64, f64), Refusal> {
        let nyquist = 0.5 / hold_s;
        let usual = excited_hz.unwrap_or(nyquist).min(0.8 * nyquist);
        let (low, high) = (self.from_hz.unwrap_or(lowest_hz), self.to_hz.unwrap_or(usual));
        require(
            low > 0.0 && low < high && high < nyquist,
            || {
                let why = if low <= 0.0 {
                    "a frequency must be above zero".to_owned()
                } else if low >= high {
                    "it ends before it begins".to_owned()
                } else {
                    format!("samples come every {hold_s} s, so frequencies end at {nyquist} Hz")
                };
                format!("no band from {low} to {high} Hz: {why}")
            },
            "name a band with --from and --to, in Hz",
        )?;
        require(
            self.confidence > 0.0 && self.confidence < 1.0,
            || format!("a confidence of {} is not a probability", self.confidence),
            "write it between 0 and 1, as in --confidence 0.95",
        )?;
        Ok((low, high))
    }

    /// Rejects a length of segments if no estimator averages over segments.
    ///
    /// # Errors
    /// The refusal.
    pub(crate) fn require_segments(&self, averages: bool) -> Result<(), Refusal> {
        require(
            self.segment_s.is_none() || averages,
            || {
                "--segment is the length of what H1, H2 and Hv average, and this estimate averages nothing"
                    .to_owned()
            },
            "add --estimator h1, h2 or hv for noise, or leave --segment out",
        )
    }
}
