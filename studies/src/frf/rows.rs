//! A response as numbers for other programs.

use std::fmt::Write as _;

use serde::Serialize;

use super::distortion::{DistortionBand, Separated};
use super::response::FrequencyResponse;

/// The values at one frequency; unknown values are NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrfRow {
    pub frequency_hz: f64,
    /// Magnitude of the measured response, dB.
    pub magnitude_db: f64,
    /// Lower end of its confidence band, dB.
    pub low_db: f64,
    /// Upper end of its confidence band, dB.
    pub high_db: f64,
    /// Phase of the measured response, degrees.
    pub phase_deg: f64,
    /// Half the width of its confidence band, degrees.
    pub phase_half_width_deg: f64,
    /// Share of the output that the input explains linearly.
    pub coherence: f64,
    /// Magnitude of the linear response, dB.
    pub linear_db: f64,
    /// Phase of the linear response, degrees.
    pub linear_deg: f64,
    /// Noise of one realisation, dB.
    pub noise_db: f64,
    /// Nonlinear distortion of one realisation, dB.
    pub distortion_db: f64,
}

/// Row `i` of a response.
pub fn row(response: &FrequencyResponse, i: usize) -> FrfRow {
    let estimate = &response.estimate;
    let one = feeler_lti::spectral::ResponseEstimate {
        response: vec![estimate.response[i]],
        variance: vec![estimate.variance[i]],
        degrees_of_freedom: vec![estimate.degrees_of_freedom[i]],
        ..Default::default()
    };
    let band = one.confidence(response.confidence)[0];
    let decibels = |value: f64| 20.0 * value.log10();
    let level = |of: fn(&Separated) -> &Vec<f64>| {
        response.separated.as_ref().map_or(f64::NAN, |levels| 0.5 * decibels(of(levels)[i]))
    };
    let magnitude_db = decibels(estimate.response[i].norm());
    FrfRow {
        frequency_hz: estimate.frequencies_hz[i],
        magnitude_db,
        low_db: decibels(band.magnitude_low),
        high_db: decibels(band.magnitude_high),
        phase_deg: estimate.response[i].arg().to_degrees(),
        phase_half_width_deg: band.phase_half_width_rad.to_degrees(),
        coherence: estimate.coherence.as_ref().map_or(f64::NAN, |c| c[i]),
        linear_db: decibels(response.linear[i].norm()),
        linear_deg: response.linear[i].arg().to_degrees(),
        noise_db: level(|levels| &levels.noise),
        distortion_db: level(|levels| &levels.distortion),
    }
}

/// All rows as CSV, with empty cells for unknown values.
pub fn csv(response: &FrequencyResponse) -> String {
    let mut text = String::from(
        "frequency_hz,magnitude_db,magnitude_low_db,magnitude_high_db,phase_deg,phase_half_width_deg,\
         coherence,linear_magnitude_db,linear_phase_deg,noise_db,distortion_db\n",
    );
    for i in 0..response.linear.len() {
        let r = row(response, i);
        let cells = [
            r.frequency_hz,
            r.magnitude_db,
            r.low_db,
            r.high_db,
            r.phase_deg,
            r.phase_half_width_deg,
            r.coherence,
            r.linear_db,
            r.linear_deg,
            r.noise_db,
            r.distortion_db,
        ];
        let cells = cells.map(|v| if v.is_finite() { v.to_string() } else { String::new() });
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

/// A response as programs read it. The book shows the comments.
#[derive(Serialize)]
struct Flat<'a> {
    /// Name of the scenario or dataset.
    name: &'a str,
    /// Input of the response.
    input: &'a str,
    /// Output of the response.
    output: &'a str,
    /// The signal that a sensor reads; `None` unless its reading is the output.
    output_reads: Option<&'a str>,
    /// Excitation and estimator in words.
    how: &'a str,
    /// Warnings of the records, and choices that were made.
    notes: &'a [String],
    /// Time for which each command is held.
    hold_s: f64,
    /// Confidence of the bands, between 0 and 1.
    confidence: f64,
    /// Frequencies of the estimate.
    frequencies_hz: &'a [f64],
    /// Measured response, output over input in SI, as pairs of real and imaginary part.
    response: Vec<[f64; 2]>,
    /// Lowest and highest magnitude within the confidence, at each frequency.
    magnitude_band: Vec<[f64; 2]>,
    /// Half of the width of the band of phases.
    phase_half_width_deg: Vec<f64>,
    /// Coherence; `None` if the estimator defines none.
    coherence: Option<&'a [f64]>,
    /// Response of linear theory at the same frequencies, as pairs.
    linear: Vec<[f64; 2]>,
    /// Variance of the noise; `None` unless the excitation separates it.
    noise_variance: Option<&'a [f64]>,
    /// Variance of nonlinear distortion; `None` unless the excitation separates it.
    distortion_variance: Option<&'a [f64]>,
    /// Bands in which distortion exceeds chance.
    distortion_bands: Vec<DistortionBand>,
    /// Whether there is distortion beyond the noise; `None` unless the excitation separates them.
    distortion_beyond_noise: Option<bool>,
    /// Differences from linear theory.
    agreement: FlatAgreement,
}

/// Differences of a measured response from the linear one.
#[derive(Serialize)]
struct FlatAgreement {
    /// Number of frequencies that count, because the response is known well there.
    frequencies_compared: usize,
    /// Largest difference of magnitude among them.
    largest_difference_db: f64,
    /// Largest difference of phase among them.
    largest_difference_deg: f64,
    /// Share of all frequencies at which the linear response lies within the confidence band.
    share_within_band: f64,
}

/// The response as a value for JSON.
pub fn json(response: &FrequencyResponse) -> impl Serialize {
    let estimate = &response.estimate;
    let complex = |values: &[feeler_lti::C64]| values.iter().map(|g| [g.re, g.im]).collect::<Vec<_>>();
    let bands = estimate.confidence(response.confidence);
    let agreement = response.agreement();
    let separated = response.separated.as_ref();
    Flat {
        name: &response.title,
        input: &response.input,
        output: &response.output,
        output_reads: response.reads.as_deref(),
        how: &response.how,
        notes: &response.notes,
        hold_s: response.hold_s,
        confidence: response.confidence,
        frequencies_hz: &estimate.frequencies_hz,
        response: complex(&estimate.response),
        magnitude_band: bands.iter().map(|band| [band.magnitude_low, band.magnitude_high]).collect(),
        phase_half_width_deg: bands.iter().map(|band| band.phase_half_width_rad.to_degrees()).collect(),
        coherence: estimate.coherence.as_deref(),
        linear: complex(&response.linear),
        noise_variance: separated.map(|levels| levels.noise.as_slice()),
        distortion_variance: separated.map(|levels| levels.distortion.as_slice()),
        distortion_bands: response.distortion_bands(),
        distortion_beyond_noise: separated.map(|levels| levels.evidence.is_beyond_noise),
        agreement: FlatAgreement {
            frequencies_compared: agreement.compared,
            largest_difference_db: agreement.decibels,
            largest_difference_deg: agreement.degrees,
            share_within_band: agreement.within,
        },
    }
}
