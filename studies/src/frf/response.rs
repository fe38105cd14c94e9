//! A response estimated from records, with the linear one at the same frequencies.

use feeler_lti::C64;
use feeler_lti::spectral::ResponseEstimate;

use super::distortion::{DistortionBand, Separated, bands};

/// A response estimated from records, with the linear one at the same frequencies.
#[derive(Clone, Debug)]
pub struct FrequencyResponse {
    /// Name of the machine or dataset.
    pub title: String,
    /// Description from its file.
    pub about: String,
    pub input: String,
    pub output: String,
    /// The signal that a sensor reads, if its reading is the output.
    pub reads: Option<String>,
    /// Excitation and estimator in words.
    pub how: String,
    /// Assumptions that were made.
    pub notes: Vec<String>,
    /// Time for which each command is held, s.
    pub hold_s: f64,
    /// The estimate, output over input in SI.
    pub estimate: ResponseEstimate,
    /// The linear response at its frequencies.
    pub linear: Vec<C64>,
    /// Whether each frequency stands alone, without measurements in between.
    pub isolated: bool,
    /// The linear response at frequencies (Hz) between those of the estimate, without measurements.
    pub between: Vec<(f64, C64)>,
    /// Noise and distortion, if the excitation separates them.
    pub separated: Option<Separated>,
    /// Confidence of the bands, between 0 and 1.
    pub confidence: f64,
}

/// Levels of noise and distortion relative to the response, as powers.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// Noise of one realisation, median over frequency.
    pub noise: f64,
    /// Smallest detectable distortion.
    pub shows_from: f64,
    pub is_beyond_noise: bool,
    pub bands: Vec<DistortionBand>,
}

impl FrequencyResponse {
    /// The bands with distortion; empty if all of it may be noise.
    pub(crate) fn distortion_bands(&self) -> Vec<DistortionBand> {
        let beyond = self.separated.as_ref().filter(|separated| separated.evidence.is_beyond_noise);
        beyond.map_or_else(Vec::new, |separated| {
            bands(separated, &self.estimate.frequencies_hz, &self.estimate.response)
        })
    }

    /// Levels of noise and distortion; `None` if the excitation does not separate them.
    pub fn levels(&self) -> Option<Levels> {
        let Separated { noise, evidence, .. } = self.separated.as_ref()?;
        let mut shares: Vec<f64> =
            noise.iter().zip(&self.estimate.response).map(|(v, g)| v / g.norm_sqr()).collect();
        shares.retain(|share| share.is_finite());
        shares.sort_by(f64::total_cmp);
        let noise = shares.get(shares.len() / 2).copied().unwrap_or(0.0);
        Some(Levels {
            noise,
            shows_from: noise * evidence.least_share,
            is_beyond_noise: evidence.is_beyond_noise,
            bands: self.distortion_bands(),
        })
    }
}
