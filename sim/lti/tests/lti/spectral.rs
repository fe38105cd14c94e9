//! Estimators against systems whose response is known exactly.

use std::f64::consts::TAU;

use feeler_lti::spectral::{
    CrossSpectra, Estimator, LocalPolynomialSettings, Multisine, PeriodicRecord, ResponseEstimate,
    SteppedSinePoint, WelchSettings, Window, amplitude_spectrum, best_linear_approximation, cross_spectra,
    dominant_frequency, local_polynomial, periodic_response, smoothed_spectra, stepped_sine,
};
use feeler_lti::{C64, DiscreteStateSpace, LtiError};

use crate::common::{PERIOD_S, Uniform, plant, respond};

fn truth(system: &DiscreteStateSpace, estimate: &ResponseEstimate) -> Vec<C64> {
    system.frequency_response(&estimate.frequencies_hz).unwrap().into_iter().map(|m| m[(0, 0)]).collect()
}

fn add(a: &[f64], b: &[f64], factor: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}

/// Share of the values whose 95 % band (magnitude and phase) contains the true value.
fn coverage(system: &DiscreteStateSpace, estimate: &ResponseEstimate) -> f64 {
    let values = estimate.response.iter().zip(truth(system, estimate)).zip(estimate.confidence(0.95));
    let held = values.filter(|((found, truth), band)| {
        let phase = (*found / truth).arg().abs();
        (band.magnitude_low..=band.magnitude_high).contains(&truth.norm())
            && phase <= band.phase_half_width_rad
    });
    held.count() as f64 / estimate.response.len() as f64
}

/// A band made of a disk's extremes contains slightly more than the disk; with some hundred lines the share
/// is known to about 2 %.
const COVERAGE: std::ops::RangeInclusive<f64> = 0.93..=1.0;

#[test]
fn truth_noise_response_lies_in_its_band() {
    let (system, mut random) = (plant(), Uniform(1));
    let input = random.normal(200_000);
    let output = add(&respond(&system, &input), &random.normal(input.len()), 0.3);
    let spectra = cross_spectra(&input, &output, PERIOD_S, &WelchSettings::hann(1000)).unwrap();
    let estimate = spectra.response(Estimator::H1, 2.0, 300.0).unwrap();
    assert_eq!(estimate.response.len(), 299);
    assert!(COVERAGE.contains(&coverage(&system, &estimate)), "{}", coverage(&system, &estimate));
    // The bands are narrow where the coherence is high: a few per cent.
    let low = estimate.within(2.0, 40.0);
    assert!(
        low.confidence(0.95)
            .iter()
            .zip(&low.response)
            .all(|(b, g)| b.magnitude_high - b.magnitude_low < 0.2 * g.norm())
    );
    // Overlapping Hann windows of white noise amount to a little less than twice the disjoint segments.
    assert!(spectra.averages > 1.7 * 200.0 && spectra.averages < 2.0 * 200.0);
}

#[test]
fn truth_estimators_are_ordered() {
    let (system, mut random) = (plant(), Uniform(2));
    let clean = random.normal(20_000);
    let output = add(&respond(&system, &clean), &random.normal(clean.len()), 0.5);
    let input = add(&clean, &random.normal(clean.len()), 0.5);
    let spectra = cross_spectra(&input, &output, PERIOD_S, &WelchSettings::hann(500)).unwrap();
    let by = |estimator| spectra.response(estimator, 2.0, 400.0).unwrap().response;
    for ((h1, h2), hv) in by(Estimator::H1).iter().zip(by(Estimator::H2)).zip(by(Estimator::Hv)) {
        assert!(h1.norm() <= hv.norm() && hv.norm() <= h2.norm());
        // All three have the phase of the cross spectrum.
        assert!((h1 / h2).arg().abs() < 1e-12 && (h1 / hv).arg().abs() < 1e-12);
        assert!((hv.norm_sqr() / (h1 * h2).norm() - 1.0).abs() < 1e-12);
    }
    assert!(spectra.coherence().iter().all(|c| (0.0..=1.0).contains(c)));
}

#[test]
fn truth_density_of_white_noise() {
    let input = Uniform(3).normal(400_000);
    let CrossSpectra { input: density, .. } =
        cross_spectra(&input, &input, PERIOD_S, &WelchSettings::hann(256)).unwrap();
    // Variance 1 over 0 to 500 Hz; each line is known to 1 / sqrt(3000), their mean to 1 / sqrt(400000).
    let mean = density[2..127].iter().sum::<f64>() / 125.0;
    assert!((mean * 500.0 - 1.0).abs() < 0.01, "{mean}");
}

#[test]
fn truth_local_polynomial_removes_leakage() {
    let (system, mut random) = (plant(), Uniform(4));
    let input = random.normal(4000);
    let output = respond(&system, &input);
    let estimate =
        local_polynomial(&input, &output, PERIOD_S, &LocalPolynomialSettings::default(), (5.0, 400.0))
            .unwrap();
    let worst = estimate
        .response
        .iter()
        .zip(truth(&system, &estimate))
        .map(|(g, t)| (g - t).norm() / t.norm())
        .fold(0.0, f64::max);
    // Local cubic remainder: a mode 16 Hz wide over 3 Hz leaves about 1e-3; one windowed record leaves
    // several per cent.
    assert!(worst < 1e-2, "{worst}");
    let noisy = add(&output, &random.normal(input.len()), 0.3);
    let estimate =
        local_polynomial(&input, &noisy, PERIOD_S, &LocalPolynomialSettings::default(), (5.0, 400.0))
            .unwrap();
    assert!(COVERAGE.contains(&coverage(&system, &estimate)), "{}", coverage(&system, &estimate));
}

fn multisine(lines: Vec<usize>, seed: u64) -> Multisine {
    let mut random = Uniform(seed);
    let phases = lines.iter().map(|_| TAU * random.draw()).collect();
    Multisine::new(1000, lines, 1.0, phases).unwrap()
}

fn repeat(period: &[f64], periods: usize) -> Vec<f64> {
    period.iter().copied().cycle().take(period.len() * periods).collect()
}

fn record<'a>(input: &'a [f64], output: &'a [f64]) -> PeriodicRecord<'a> {
    PeriodicRecord { input, output, period_s: PERIOD_S, samples_per_period: 1000, transient_periods: 2 }
}

#[test]
fn truth_periodic_response_is_exact_without_noise_and_banded_with() {
    let (system, lines) = (plant(), (1..400).collect::<Vec<usize>>());
    let input = repeat(&multisine(lines.clone(), 5).period(), 12);
    let output = respond(&system, &input);
    let exact = periodic_response(&record(&input, &output), &lines).unwrap();
    let worst = exact
        .response
        .iter()
        .zip(truth(&system, &exact))
        .map(|(g, t)| (g - t).norm() / t.norm())
        .fold(0.0, f64::max);
    // Transients have decayed by exp(-50 * 2) after two periods; the remainder is rounding over the smallest
    // response.
    assert!(worst < 1e-10, "{worst}");
    let noisy = add(&output, &Uniform(6).normal(input.len()), 0.3);
    let estimate = periodic_response(&record(&input, &noisy), &lines).unwrap();
    assert!(COVERAGE.contains(&coverage(&system, &estimate)), "{}", coverage(&system, &estimate));
    assert_eq!(
        periodic_response(&record(&input, &noisy), &[501]).unwrap_err(),
        LtiError::OutOfRange { quantity: "line", value: 501.0, range: "[0, samples per period / 2]" }
    );
}

/// y = G (u + e u^3): by Bussgang's theorem the best linear approximation is G (1 + 3 e) for a normal u of
/// variance 1.
#[test]
fn truth_best_linear_approximation_of_a_cubic() {
    let (system, lines) = (plant(), (1..200).collect::<Vec<usize>>());
    let run = |cubic: f64, noise: f64, seed: u64| {
        let input = repeat(&multisine(lines.clone(), seed).period(), 6);
        let bent: Vec<f64> = input.iter().map(|u| u + cubic * u.powi(3)).collect();
        let output = add(&respond(&system, &bent), &Uniform(seed + 100).normal(input.len()), noise);
        (input, output)
    };
    let estimate = |cubic: f64, noise: f64| {
        let runs: Vec<_> = (0..20).map(|seed| run(cubic, noise, seed)).collect();
        let realisations: Vec<_> = runs.iter().map(|(u, y)| record(u, y)).collect();
        best_linear_approximation(&realisations, &lines).unwrap()
    };
    let bent = estimate(0.1, 0.01);
    let ratios = bent.estimate.response.iter().zip(truth(&system, &bent.estimate)).map(|(g, t)| g / t);
    let mean = ratios.sum::<C64>() / lines.len() as f64;
    // The mean over 199 lines and 20 realisations is known to about 0.2 %; a finite number of lines biases it
    // by 1 / 199.
    assert!((mean - 1.3).norm() < 0.01, "{mean}");
    let distortion =
        |b: &feeler_lti::spectral::BestLinearApproximation| b.distortion_variance.iter().sum::<f64>();
    let linear = estimate(0.0, 0.01);
    assert!(distortion(&bent) > 20.0 * distortion(&linear));
    // Noise: variance 1e-4 per sample, four periods, 20 realisations: 2 * 1e-4 * 2 / 1000 / 4 / 20 over the
    // input's power of 2 / 199.
    let expected = 4e-4 / 1000.0 / 4.0 / 20.0 / (2.0 / 199.0);
    let noise = linear.noise_variance.iter().sum::<f64>() / lines.len() as f64;
    assert!((noise / expected - 1.0).abs() < 0.1, "{noise} against {expected}");
}

#[test]
fn truth_stepped_sine_is_exact_in_steady_state() {
    let system = plant();
    let records: Vec<(f64, Vec<f64>, Vec<f64>)> = [3.3, 40.0, 123.4]
        .into_iter()
        .map(|f| {
            let input: Vec<f64> =
                (0..2000).map(|i| 0.5 + (TAU * f * PERIOD_S * f64::from(i)).sin()).collect();
            let output = respond(&system, &input);
            (f, input[1000..].to_vec(), output[1000..].to_vec())
        })
        .collect();
    let points: Vec<_> =
        records.iter().map(|(f, u, y)| SteppedSinePoint { frequency_hz: *f, input: u, output: y }).collect();
    let estimate = stepped_sine(&points, PERIOD_S).unwrap();
    for (found, expected) in estimate.response.iter().zip(truth(&system, &estimate)) {
        // The transient has decayed by exp(-50); rounding remains.
        assert!((found - expected).norm() < 1e-11 * expected.norm());
    }
}

#[test]
fn truth_chirp_between_rests() {
    let system = plant();
    // 1 to 450 Hz in 8 s, then rest until the response is gone.
    let chirp = |i: u32| {
        let t = f64::from(i) * PERIOD_S;
        if t < 8.0 { (TAU * (1.0 + 0.5 * 449.0 / 8.0 * t) * t).sin() } else { 0.0 }
    };
    let input: Vec<f64> = (0..10_000).map(chirp).collect();
    let output = respond(&system, &input);
    let estimate =
        smoothed_spectra(&input, &output, PERIOD_S, 2).unwrap().response(Estimator::H1, 3.0, 420.0).unwrap();
    let worst = estimate
        .response
        .iter()
        .zip(truth(&system, &estimate))
        .map(|(g, t)| (g - t).norm() / t.norm())
        .fold(0.0, f64::max);
    // Averaging over 0.5 Hz of a mode 16 Hz wide.
    assert!(worst < 1e-2, "{worst}");
}

#[test]
fn truth_amplitude_and_dominant_frequency() {
    let record: Vec<f64> = (0..1000)
        .map(|i| {
            let t = f64::from(i) * PERIOD_S;
            7.0 + 2.0 * (TAU * 50.0 * t).cos() + 0.5 * (TAU * 120.0 * t).sin()
        })
        .collect();
    for window in [Window::Rectangular, Window::Hann, Window::Hamming, Window::Blackman, Window::FlatTop] {
        let spectrum = amplitude_spectrum(&record, PERIOD_S, window).unwrap();
        assert!((spectrum.frequencies_hz[50] - 50.0).abs() < 1e-12);
        // Whole periods: lines of a cosine-sum window do not disturb each other at this distance.
        assert!(
            (spectrum.amplitudes[50] - 2.0).abs() < 1e-12 && (spectrum.amplitudes[120] - 0.5).abs() < 1e-12,
            "{window:?}"
        );
    }
    let (frequency_hz, amplitude) = dominant_frequency(&record, PERIOD_S, (80.0, 400.0)).unwrap().unwrap();
    assert!((frequency_hz - 120.0).abs() < 1e-3 && (amplitude - 0.5).abs() < 1e-4);
    // The transform itself, at the found frequency and beside it: no neighbour is larger, and the amplitude
    // is that of the transform there.
    let mean = record.iter().sum::<f64>() / record.len() as f64;
    let weights = Window::Hann.weights(record.len());
    let at = |hz: f64| {
        let term =
            |(i, (v, w)): (usize, (&f64, &f64))| C64::cis(-TAU * hz * PERIOD_S * i as f64) * ((v - mean) * w);
        2.0 * record.iter().zip(&weights).enumerate().map(term).sum::<C64>().norm()
            / weights.iter().sum::<f64>()
    };
    assert!((at(frequency_hz) - amplitude).abs() < 1e-12);
    assert!(at(frequency_hz) >= at(frequency_hz - 1e-4) && at(frequency_hz) >= at(frequency_hz + 1e-4));
    assert_eq!(dominant_frequency(&[1.0; 64], PERIOD_S, (1.0, 400.0)).unwrap(), None);
}
