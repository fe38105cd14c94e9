//! What can be asked for when a frequency response is estimated.

use feeler_lti::spectral::Estimator;
use feeler_plant::description::Engagement;

use super::error::require;
use crate::refusal::Refusal;

/// A frequency response that is wanted; what is absent is chosen from the machine or the records.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// The actuator's command, or a dataset's column.
    pub input: Option<String>,
    /// The signal, or a dataset's column.
    pub output: Option<String>,
    /// How the machine is excited, or was.
    pub excitation: Option<ExcitationKind>,
    /// How records of noise become a response.
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
    /// Periods of the multisine that are evaluated.
    pub periods: Option<usize>,
    /// Draws of the multisine's phases.
    pub realisations: Option<usize>,
    /// Frequencies of the stepped sine.
    pub points: Option<usize>,
    /// Time for which each command is held, s.
    pub hold_s: Option<f64>,
    /// Seed of excitation and noise.
    pub seed: Option<u64>,
    /// How every contact is taken.
    pub engagement: Option<Engagement>,
    /// Confidence of the bands, between 0 and 1.
    pub confidence: f64,
    /// Records of a dataset by name; the first one unless others are named.
    pub experiments: Vec<String>,
}

impl Default for Request {
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

/// What a machine is excited with.
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

/// How records of noise become a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseEstimator {
    /// Polynomials through neighbouring lines of the whole record, which estimate the leakage too.
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

impl Request {
    /// The band that is looked at, Hz, for samples that come every `hold_s`.
    ///
    /// # Errors
    /// A band that is empty or beyond half the sampling rate, or a confidence that is no probability.
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
            || format!("a confidence of {} is no probability", self.confidence),
            "write it as in --confidence 0.95",
        )?;
        Ok((low, high))
    }

    /// Refuses a length of segments where no estimator averages over them.
    ///
    /// # Errors
    /// The refusal.
    pub fn require_segments(&self, averages: bool) -> Result<(), Refusal> {
        require(
            self.segment_s.is_none() || averages,
            || {
                "--segment is the length of what H1, H2 and Hv average of noise, and nothing is averaged here"
                    .to_owned()
            },
            "add --estimator h1, h2 or hv for noise, or leave --segment out",
        )
    }
}
