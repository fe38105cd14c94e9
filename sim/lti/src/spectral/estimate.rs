//! An estimated frequency response with its uncertainty.

use crate::domain::C64;

/// Frequency response at some frequencies, with the variance of each value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ResponseEstimate {
    /// Frequencies, Hz, rising.
    pub frequencies_hz: Vec<f64>,
    /// Estimated response, unit of the output over unit of the input.
    pub response: Vec<C64>,
    /// Estimated variance E|G - G0|^2 of each value.
    pub variance: Vec<f64>,
    /// Real degrees of freedom of each variance.
    pub degrees_of_freedom: Vec<f64>,
    /// Coherence in [0, 1], if the estimator provides one.
    pub coherence: Option<Vec<f64>>,
}

/// Confidence band of one value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponseBand {
    /// Lower end of the magnitude.
    pub magnitude_low: f64,
    /// Upper end of the magnitude.
    pub magnitude_high: f64,
    /// Half width of the phase, rad; pi if the phase is unknown.
    pub phase_half_width_rad: f64,
}

impl ResponseEstimate {
    /// Bands of magnitude and phase that contain the true value with the given confidence (such as 0.95).
    ///
    /// The estimate lies in a disk about the true value. Its squared distance over the variance has an F
    /// distribution with 2 and nu degrees of freedom, whose quantile is nu/2 (alpha^(-2/nu) - 1). Source:
    /// Bendat and Piersol, Random Data (4th ed.), equation 9.97.
    pub fn confidence(&self, confidence: f64) -> Vec<ResponseBand> {
        let alpha = 1.0 - confidence;
        let values = self.response.iter().zip(&self.variance).zip(&self.degrees_of_freedom);
        values
            .map(|((response, variance), nu)| {
                // Through expm1, since for large nu the power is close to 1; its limit is -ln alpha.
                let quantile =
                    if nu.is_finite() { 0.5 * nu * (-2.0 / nu * alpha.ln()).exp_m1() } else { -alpha.ln() };
                let (magnitude, radius) = (response.norm(), (variance * quantile).sqrt());
                ResponseBand {
                    magnitude_low: (magnitude - radius).max(0.0),
                    magnitude_high: magnitude + radius,
                    phase_half_width_rad: if radius < magnitude {
                        (radius / magnitude).asin()
                    } else {
                        std::f64::consts::PI
                    },
                }
            })
            .collect()
    }

    /// The part between two frequencies, ends included.
    #[must_use]
    pub fn within(&self, low_hz: f64, high_hz: f64) -> Self {
        let kept: Vec<usize> = (0..self.frequencies_hz.len())
            .filter(|&i| (low_hz..=high_hz).contains(&self.frequencies_hz[i]))
            .collect();
        let pick = |values: &[f64]| kept.iter().map(|&i| values[i]).collect::<Vec<f64>>();
        Self {
            frequencies_hz: pick(&self.frequencies_hz),
            response: kept.iter().map(|&i| self.response[i]).collect(),
            variance: pick(&self.variance),
            degrees_of_freedom: pick(&self.degrees_of_freedom),
            coherence: self.coherence.as_deref().map(pick),
        }
    }
}
