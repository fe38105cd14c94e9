//! In which bands nonlinear distortion exceeds the noise, and how large it is there.

use feeler_lti::C64;

use super::ToldApart;
use crate::numbers::{plain, with_unit};

/// Standard deviations by which a band's distortion must exceed what the noise makes of it.
const DEVIATIONS: f64 = 5.0;
/// Fewest lines of a band, and the ratio of its ends at least: halves of an octave.
const FEWEST: usize = 4;
const RATIO: f64 = std::f64::consts::SQRT_2;
/// Bands that are named.
const NAMED: usize = 3;

/// A band in which there is distortion.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct DistortionBand {
    pub(crate) low_hz: f64,
    pub(crate) high_hz: f64,
    /// Power over that of the response, each summed over the band.
    pub(crate) share: f64,
    #[serde(skip)]
    sums: [f64; 2],
}

/// The bands in which distortion exceeds the noise, rising, neighbours joined. Line by line its unbiased
/// variance scatters as much as the noise; summed over a band it does not.
pub(crate) fn bands(told_apart: &ToldApart, frequencies_hz: &[f64], response: &[C64]) -> Vec<DistortionBand> {
    let mut found: Vec<DistortionBand> = Vec::new();
    let mut before = false;
    let mut start = 0;
    while start < frequencies_hz.len() {
        let reach = RATIO * frequencies_hz[start];
        let mut end =
            frequencies_hz.partition_point(|f| *f < reach).max(start + FEWEST).min(frequencies_hz.len());
        // What is left over is no band of its own.
        if frequencies_hz.len() - end < FEWEST {
            end = frequencies_hz.len();
        }
        let exceeds = stands_out(told_apart, start..end);
        if exceeds {
            let distortion: f64 = told_apart.distortion[start..end].iter().sum();
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

/// Whether the distortion of some lines, summed, exceeds what noise makes of it: with `a` and `b` complex
/// degrees of freedom, a line's total and noise have variances of `1 / a` and `1 / b` of the noise squared.
fn stands_out(told_apart: &ToldApart, lines: std::ops::Range<usize>) -> bool {
    let evidence = &told_apart.evidence;
    let (a, b) = (evidence.degrees.total as f64, evidence.degrees.noise as f64);
    // Lines known from fewer ones beside them are not known independently.
    let shared = (told_apart.noise.len() as f64 / evidence.lines as f64).max(1.0);
    let distortion: f64 = told_apart.distortion[lines.clone()].iter().sum();
    let noise: f64 = told_apart.noise[lines].iter().map(|n| n * n).sum();
    distortion > DEVIATIONS * (noise * (1.0 / a + 1.0 / b) * shared).sqrt()
}

/// The strongest bands in words.
pub(crate) fn words(mut bands: Vec<DistortionBand>, decibels: impl Fn(f64) -> String) -> String {
    bands.sort_by(|a, b| b.share.total_cmp(&a.share));
    let named: Vec<String> = (bands.iter().take(NAMED))
        .map(|band| {
            format!(
                "{} from {} to {}",
                decibels(band.share),
                plain(band.low_hz),
                with_unit(band.high_hz, "Hz")
            )
        })
        .collect();
    let rest = if bands.len() > NAMED { ", less in other bands" } else { "" };
    named.join(", ") + rest
}

#[cfg(test)]
mod tests {
    use feeler_lti::spectral::{ComplexDegrees, Evidence};

    use super::*;

    #[test]
    fn truth_only_the_band_that_distorts_is_named() {
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
        let told_apart = ToldApart { noise: vec![1.0; 100], distortion, evidence };
        let found = bands(&told_apart, &frequencies, &vec![C64::new(10.0, 0.0); 100]);
        let [only] = found.as_slice() else { panic!("{found:?}") };
        assert!((7.0..=10.0).contains(&only.low_hz) && (20.0..=29.0).contains(&only.high_hz), "{only:?}");
        assert!((0.1..=0.2).contains(&only.share), "{only:?}");
        assert!(words(found, |share| format!("{share:.1}")).contains("Hz"));
    }
}
