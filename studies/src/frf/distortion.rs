//! Bands in which nonlinear distortion exceeds the noise, and its size there.

use feeler_lti::C64;
use feeler_lti::spectral::Evidence;

/// Standard deviations by which a band's distortion must exceed the expected noise.
const DEVIATIONS: f64 = 5.0;
/// Smallest number of lines of a band, and smallest ratio of its ends: half an octave.
const FEWEST: usize = 4;
const RATIO: f64 = std::f64::consts::SQRT_2;

/// Noise and nonlinear distortion, as periodic excitations separate them.
#[derive(Clone, Debug)]
pub struct Separated {
    /// Variance of one realisation by noise, per frequency.
    pub noise: Vec<f64>,
    /// Variance of one realisation by distortion; without distortion it is negative at about half of the
    /// frequencies.
    pub distortion: Vec<f64>,
    pub evidence: Evidence,
}

/// A band in which there is distortion.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct DistortionBand {
    /// First frequency, Hz.
    pub low_hz: f64,
    /// Last frequency, Hz.
    pub high_hz: f64,
    /// Power relative to the response, each summed over the band.
    pub share: f64,
    #[serde(skip)]
    sums: [f64; 2],
}

/// The bands in which distortion exceeds the noise, rising, with neighbours joined. On a single line its
/// unbiased variance scatters as much as the noise; summed over a band it does not.
pub(super) fn bands(separated: &Separated, frequencies_hz: &[f64], response: &[C64]) -> Vec<DistortionBand> {
    let mut found: Vec<DistortionBand> = Vec::new();
    let mut before = false;
    let mut start = 0;
    while start < frequencies_hz.len() {
        let reach = RATIO * frequencies_hz[start];
        let mut end =
            frequencies_hz.partition_point(|f| *f < reach).max(start + FEWEST).min(frequencies_hz.len());
        // The remaining lines are not a separate band.
        if frequencies_hz.len() - end < FEWEST {
            end = frequencies_hz.len();
        }
        let exceeds = stands_out(separated, start..end);
        if exceeds {
            let distortion: f64 = separated.distortion[start..end].iter().sum();
            let power: f64 = response[start..end].iter().map(C64::norm_sqr).sum();
            let high_hz = frequencies_hz[end - 1];
            match found.last_mut().filter(|_| before) {
                Some(band) => {
                    band.high_hz = high_hz;
                    band.sums = [band.sums[0] + distortion, band.sums[1] + power];
                }
                None => found.push(DistortionBand {
                    low_hz: frequencies_hz[start],
                    high_hz,
                    share: 0.0,
                    sums: [distortion, power],
                }),
            }
        }
        before = exceeds;
        start = end;
    }
    for band in &mut found {
        band.share = band.sums[0] / band.sums[1];
    }
    found
}

/// Whether the summed distortion of some lines exceeds the expected noise. With `a` and `b` complex degrees
/// of freedom, a line's total and noise have variances of `1 / a` and `1 / b` of the noise squared.
fn stands_out(separated: &Separated, lines: std::ops::Range<usize>) -> bool {
    let evidence = &separated.evidence;
    let (a, b) = (evidence.degrees.total as f64, evidence.degrees.noise as f64);
    // Lines whose noise comes from a smaller number of neighbours are not independent.
    let shared = (separated.noise.len() as f64 / evidence.lines as f64).max(1.0);
    let distortion: f64 = separated.distortion[lines.clone()].iter().sum();
    let noise: f64 = separated.noise[lines].iter().map(|n| n * n).sum();
    distortion > DEVIATIONS * (noise * (1.0 / a + 1.0 / b) * shared).sqrt()
}

#[cfg(test)]
mod tests {
    use feeler_lti::spectral::{ComplexDegrees, Evidence};

    use super::*;

    #[test]
    fn truth_only_the_band_that_distorts_is_found() {
        // Noise of 1 line by line, whose unbiased excess is +-1 in turn, and distortion of 4 from 10 to 20
        // Hz.
        let frequencies: Vec<f64> = (1..=100).map(f64::from).collect();
        let distortion = (1..=100)
            .map(|f| if f % 2 == 0 { 1.0 } else { -1.0 } + if (10..=20).contains(&f) { 20.0 } else { 0.0 })
            .collect();
        let evidence = Evidence {
            is_beyond_noise: true,
            least_share: 0.1,
            degrees: ComplexDegrees { total: 3, noise: 12 },
            lines: 100,
        };
        let separated = Separated { noise: vec![1.0; 100], distortion, evidence };
        let found = bands(&separated, &frequencies, &vec![C64::new(10.0, 0.0); 100]);
        let [only] = found.as_slice() else { panic!("{found:?}") };
        assert!((7.0..=10.0).contains(&only.low_hz) && (20.0..=29.0).contains(&only.high_hz), "{only:?}");
        assert!((0.1..=0.2).contains(&only.share), "{only:?}");
    }
}
