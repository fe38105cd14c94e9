//! Sums of sines, and recognition of a record's excitation.

use std::f64::consts::TAU;

use feeler_lti::spectral::{
    PeriodicRecord, RecordedExcitation, distortion_beside, excited_lines, find_sines, periodic_response,
    recognise_excitation, response_at_sines,
};
use feeler_lti::{C64, DiscreteStateSpace};

use crate::common::{PERIOD_S, Uniform, plant, respond};

const SAMPLES: usize = 4000;

/// Frequencies without a common period within the record: 0.7 Hz apart below 12 Hz, 4.7 Hz above.
fn frequencies() -> Vec<f64> {
    let (mut all, mut f) = (Vec::new(), 0.83);
    while f < 160.0 {
        all.push(f);
        f += if f < 12.0 { 0.713 } else { 4.717 };
    }
    all
}

fn sines(frequencies_hz: &[f64], seed: u64) -> Vec<f64> {
    let mut random = Uniform(seed);
    let phases: Vec<f64> = frequencies_hz.iter().map(|_| TAU * random.draw()).collect();
    let value = |i: usize| -> f64 {
        frequencies_hz.iter().zip(&phases).map(|(f, p)| (TAU * f * i as f64 * PERIOD_S + p).sin()).sum()
    };
    (0..SAMPLES).map(value).collect()
}

fn truth(system: &DiscreteStateSpace, frequencies_hz: &[f64]) -> Vec<C64> {
    system.frequency_response(frequencies_hz).unwrap().into_iter().map(|m| m[(0, 0)]).collect()
}

#[test]
fn truth_the_sines_of_a_record_are_found() {
    let wanted = frequencies();
    let found = find_sines(&sines(&wanted, 1), PERIOD_S).unwrap();
    assert_eq!(found.frequencies_hz.len(), wanted.len());
    for ((f, w), a) in found.frequencies_hz.iter().zip(&wanted).zip(&found.amplitudes) {
        // Gauss-Newton steps converge according to the distance of neighbours; a millionth of a line remains.
        assert!((f - w).abs() < 1e-4 && (a - 1.0).abs() < 1e-3, "{f} {w} {a}");
    }
}

#[test]
fn truth_response_at_sines_is_that_of_the_machine_and_lies_in_its_band() {
    let (system, wanted) = (plant(), frequencies());
    let input = sines(&wanted, 2);
    let clean = respond(&system, &input);
    let exact = response_at_sines(&input, &clean, PERIOD_S, &wanted).unwrap();
    for ((g, t), f) in exact.response.iter().zip(truth(&system, &wanted)).zip(&wanted) {
        // The machine starts at rest: a transient of about 1 / (2 pi 8) s. Hann's window weights it by (pi
        // 0.02 / 4)^2, three in ten thousand of the sines over the record's 4 s.
        assert!((g - t).norm() < 3e-4, "{f} Hz: {g} {t}");
    }
    let mut held = 0;
    for seed in 0..10 {
        let noise = Uniform(seed + 100).normal(SAMPLES);
        let noisy: Vec<f64> = clean.iter().zip(&noise).map(|(y, e)| y + 0.3 * e).collect();
        let estimate = response_at_sines(&input, &noisy, PERIOD_S, &wanted).unwrap();
        let bands = estimate.confidence(0.95);
        let values = estimate.response.iter().zip(truth(&system, &wanted)).zip(bands);
        held += values.filter(|((g, t), band)| (*g - t).norm() <= band.magnitude_high - g.norm()).count();
    }
    // Several hundred values: the share is known to about 1 %. Noise that is known from a few lines only adds
    // the same spread.
    let share = f64::from(u32::try_from(held).unwrap()) / (10.0 * wanted.len() as f64);
    assert!((0.92..=0.98).contains(&share), "{share}");
}

#[test]
fn truth_each_way_to_excite_is_recognised() {
    let recognise = |record: &[f64]| recognise_excitation(record, PERIOD_S).unwrap();
    let noise = Uniform(3).normal(SAMPLES);
    let Ok(RecordedExcitation::Sines(found)) = recognise_excitation(&sines(&frequencies(), 4), PERIOD_S)
    else {
        panic!("no sines")
    };
    assert_eq!(found.frequencies_hz.len(), frequencies().len());
    let lines: Vec<f64> = (1..200).map(f64::from).collect();
    assert_eq!(
        recognise(&sines(&lines, 5)),
        RecordedExcitation::Periodic { samples_per_period: 1000, periods: 4 }
    );
    assert!(matches!(recognise(&noise), RecordedExcitation::Noise { evenness } if evenness > 0.8));
    assert!(matches!(recognise(&noise[..500]), RecordedExcitation::Noise { .. }));
    let chirp: Vec<f64> =
        (0..SAMPLES).map(|i| i as f64 * PERIOD_S).map(|t| (TAU * (1.0 + 25.0 * t) * t).sin()).collect();
    assert_eq!(recognise(&chirp), RecordedExcitation::Sweep);
    // Further sweeps, in records that begin or end in silence: from a higher frequency, with a geometric
    // progression, and over less than an octave.
    let linear = |from_hz: f64, t: f64| (TAU * (from_hz + 30.0 * t) * t).sin();
    let geometric = |t: f64| (TAU * 2.0 * 2.5 / 80_f64.ln() * (80_f64.powf(t / 2.5) - 1.0)).sin();
    let octave = |t: f64| (TAU * (60.0 + 12.0 * t) * t).sin();
    let sweeps: [&dyn Fn(f64) -> f64; 4] = [&|t| linear(1.0, t), &|t| linear(20.0, t), &geometric, &octave];
    for (which, sweep) in sweeps.into_iter().enumerate() {
        for begins_s in [0.0, 0.5, 1.5] {
            let value = |i: usize| {
                let t = i as f64 * PERIOD_S - begins_s;
                if (0.0..2.5).contains(&t) { 3.0 + sweep(t) } else { 3.0 }
            };
            let record: Vec<f64> = (0..SAMPLES).map(value).collect();
            assert_eq!(recognise(&record), RecordedExcitation::Sweep, "{which} from {begins_s} s on");
        }
    }
    let steps: Vec<f64> =
        (0..SAMPLES).map(|i| [15.0, 30.0, 10.0, 40.0][i / 1000] + 0.01 * noise[i]).collect();
    assert!(matches!(recognise(&steps), RecordedExcitation::Uneven { .. }), "{:?}", recognise(&steps));
}

/// y = G (u + e u^2): the square appears on the lines that the multisine omits.
#[test]
fn truth_distortion_shows_beside_the_lines_of_one_multisine() {
    let system = plant();
    let odd: Vec<f64> = (0..60).map(|i| f64::from(2 * i + 1)).collect();
    let input = sines(&odd, 6);
    let measure = |square: f64, noise: f64| {
        let bent: Vec<f64> = input.iter().map(|u| u + square * u * u).collect();
        let output: Vec<f64> = respond(&system, &bent)
            .iter()
            .zip(Uniform(7).normal(SAMPLES))
            .map(|(y, e)| y + noise * e)
            .collect();
        let record = PeriodicRecord {
            input: &input,
            output: &output,
            period_s: PERIOD_S,
            samples_per_period: 1000,
            transient_periods: 1,
        };
        let lines = excited_lines(&record, (0.5, 200.0)).unwrap();
        assert_eq!(lines, (0..60).map(|i| 2 * i + 1).collect::<Vec<usize>>());
        let estimate = periodic_response(&record, &lines).unwrap();
        let distortion = distortion_beside(&record, &lines).unwrap().unwrap();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        (mean(&distortion.variance), mean(&estimate.variance), distortion.evidence.is_beyond_noise)
    };
    let (bent, noise, shows) = measure(0.02, 0.02);
    assert!(shows && bent > 10.0 * noise, "{bent} {noise}");
    let (none, noise, shows) = measure(0.0, 0.02);
    assert!(!shows && none < noise, "{none} {noise}");
}
