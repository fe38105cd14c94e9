//! Agreement of a measured response with the linear one, and frequencies at which the output hardly depends
//! on the input.

use super::response::FrequencyResponse;

/// Smallest coherence of frequencies in the comparison of responses: the first of these values that leaves
/// enough frequencies.
pub const COHERENT: [f64; 3] = [0.99, 0.9, 0.5];
/// Without coherence, a frequency counts if its phase is known to this number of degrees. The magnitude is
/// then known to a half.
pub const KNOWN_DEG: f64 = 30.0;
/// Enough frequencies, as a share of all.
const ENOUGH: f64 = 0.05;
/// A response with less coherence is mostly noise or distortion.
pub const INCOHERENT: f64 = 0.8;

/// Comparison of the estimate with the linear response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearAgreement {
    /// Smallest coherence of the counted frequencies; `None` if the estimate has none.
    pub coherence: Option<f64>,
    /// Frequencies that count.
    pub compared: usize,
    /// Largest difference of magnitude among them, dB.
    pub decibels: f64,
    /// Largest difference of phase among them, degrees.
    pub degrees: f64,
    /// Share of all frequencies at which the linear response lies within the confidence band.
    pub within: f64,
    /// Largest difference of magnitude over all frequencies, counted or not, dB, and its frequency, Hz.
    pub widest: [f64; 2],
}

/// The frequencies at which the coherence is below [`INCOHERENT`].
#[derive(Clone, Debug, PartialEq)]
pub struct Incoherent {
    /// Number of these frequencies.
    pub count: usize,
    /// First and last frequency of each span, Hz, rising.
    pub spans: Vec<[f64; 2]>,
}

impl FrequencyResponse {
    /// Comparison of measured and linear response.
    pub fn agreement(&self) -> LinearAgreement {
        let all = || (0..self.linear.len()).filter(|&i| self.linear[i].norm() > 0.0);
        let known = self.estimate.coherence.as_ref();
        let bands = self.estimate.confidence(self.confidence);
        let is_known = |i: usize| bands[i].phase_half_width_rad.to_degrees() <= KNOWN_DEG;
        let from = |least: f64| {
            all().filter(|&i| known.map_or_else(|| is_known(i), |c| c[i] >= least)).collect::<Vec<usize>>()
        };
        let enough = |least: &f64| from(*least).len() as f64 >= ENOUGH * self.linear.len() as f64;
        let least = COHERENT.into_iter().find(enough).unwrap_or(COHERENT[2]);
        let counts = from(least);
        let ratio = |i: usize| self.estimate.response[i] / self.linear[i];
        let apart = |i: usize| (20.0 * ratio(i).norm().log10()).abs();
        let widest = all().filter(|&i| apart(i).is_finite()).max_by(|&i, &j| apart(i).total_cmp(&apart(j)));
        let inside = (0..self.linear.len()).filter(|&i| {
            let radius = bands[i].magnitude_high - self.estimate.response[i].norm();
            (self.estimate.response[i] - self.linear[i]).norm() <= radius
        });
        LinearAgreement {
            coherence: known.map(|_| least),
            compared: counts.len(),
            decibels: counts.iter().map(|&i| apart(i)).fold(0.0, f64::max),
            degrees: counts.iter().map(|&i| ratio(i).arg().to_degrees().abs()).fold(0.0, f64::max),
            within: inside.count() as f64 / self.linear.len().max(1) as f64,
            widest: widest.map_or([0.0; 2], |i| [apart(i), self.estimate.frequencies_hz[i]]),
        }
    }

    /// Whether each frequency counts in [`Self::agreement`]: its response is known well.
    pub fn is_known(&self) -> Vec<bool> {
        let least = self.agreement().coherence;
        if let (Some(coherence), Some(least)) = (&self.estimate.coherence, least) {
            coherence.iter().map(|value| *value >= least).collect()
        } else {
            let bands = self.estimate.confidence(self.confidence);
            bands.iter().map(|band| band.phase_half_width_rad.to_degrees() <= KNOWN_DEG).collect()
        }
    }

    /// Frequencies at which the output hardly depends on the input; `None` if nothing is known.
    pub fn incoherent(&self) -> Option<Incoherent> {
        let (coherence, f) = (self.estimate.coherence.as_ref()?, &self.estimate.frequencies_hz);
        let mut spans: Vec<[f64; 2]> = Vec::new();
        let mut before = false;
        for (value, &f) in coherence.iter().zip(f) {
            let low = *value < INCOHERENT;
            match spans.last_mut() {
                Some(span) if low && before => span[1] = f,
                _ if low => spans.push([f, f]),
                _ => {}
            }
            before = low;
        }
        let count = coherence.iter().filter(|value| **value < INCOHERENT).count();
        Some(Incoherent { count, spans })
    }
}
