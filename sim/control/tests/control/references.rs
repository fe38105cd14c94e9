//! References and excitations.

use std::f64::consts::{SQRT_2, TAU};

use feeler_control::reference::{Between, ChirpSweep, Lines};
use feeler_control::{ControlError, Reference, ReferenceSpec};

const ROUNDING: f64 = 1e-11;

fn compile(spec: &ReferenceSpec) -> Reference {
    Reference::new(spec, 5, "controllers.force").expect("the spec is sound")
}

fn assert_close(actual: f64, expected: f64) {
    assert!((actual - expected).abs() < ROUNDING, "{actual} is not {expected}");
}

/// Amplitude of the line at `frequency_hz` of evenly spaced values.
fn amplitude(values: &[f64], step_s: f64, frequency_hz: f64) -> f64 {
    let (re, im) = values.iter().enumerate().fold((0.0, 0.0), |(re, im), (i, x)| {
        let (sin, cos) = (TAU * (frequency_hz * step_s * i as f64).fract()).sin_cos();
        (re + x * cos, im - x * sin)
    });
    2.0 * f64::hypot(re, im) / values.len() as f64
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn truth_steps_lines_and_tables() {
    let steps = compile(&ReferenceSpec::Steps(vec![(0.0, 20.0), (1.2, 30.0)]));
    // 12 x 0.1 is a rounding above 1.2, 3 x 0.4 likewise; that sample must include a step that falls on it.
    for (t, expected) in
        [(-1e-6, 0.0), (0.0, 20.0), (1.199_999, 20.0), (12.0 * 0.1, 30.0), (1.2 - 2e-16, 30.0), (99.0, 30.0)]
    {
        assert_close(steps.value(t), expected);
    }
    let ramp = compile(&ReferenceSpec::PiecewiseLinear(vec![(1.0, 2.0), (3.0, 10.0)]));
    for (t, expected) in [(0.0, 2.0), (1.0, 2.0), (1.5, 4.0), (3.0, 10.0), (4.0, 10.0)] {
        assert_close(ramp.value(t), expected);
    }
    let table = |between| {
        compile(&ReferenceSpec::Table {
            times_s: vec![0.0, 0.1, 0.3],
            values: vec![1.0, -1.0, 3.0],
            between,
            offset: 5.0,
        })
    };
    assert_close(table(Between::Hold).value(0.25), 4.0);
    assert_close(table(Between::Linear).value(0.25), 7.0);
    assert_close(table(Between::Linear).value(-1.0), 6.0);
    assert_close(compile(&ReferenceSpec::Constant(3.5)).value(17.0), 3.5);
}

/// The phase of a chirp, differentiated: its frequency moves as named from one end to the other.
#[test]
fn truth_chirp_frequency() {
    let (start_hz, end_hz, duration_s) = (2.0, 50.0, 4.0);
    for (sweep, quarter_hz) in
        [(ChirpSweep::Linear, 14.0), (ChirpSweep::Logarithmic, 2.0 * 25_f64.powf(0.25))]
    {
        let chirp = compile(&ReferenceSpec::Chirp {
            sweep,
            amplitude: 3.0,
            start_hz,
            end_hz,
            duration_s,
            offset: 1.0,
        });
        // Rising zero crossings around a quarter of the duration.
        let step_s = 1e-6;
        let crossings: Vec<f64> = (900_000..1_400_000)
            .map(|i| f64::from(i) * step_s)
            .filter(|&t| chirp.value(t - step_s) < 1.0 && chirp.value(t) >= 1.0)
            .collect();
        let (first, second) = (crossings[0], crossings[1]);
        let middle = 0.5 * (first + second);
        let slope_hz_per_s = match sweep {
            ChirpSweep::Linear => 12.0,
            ChirpSweep::Logarithmic => quarter_hz * 25_f64.ln() / duration_s,
        };
        // The mean frequency of one cycle is that of its middle up to second order: (slope / f)^2 / f / 24,
        // less than 1e-3 here. The crossings are found to 1e-6 s of 0.1 s.
        let expected_hz = quarter_hz + slope_hz_per_s * (middle - 1.0);
        assert!((1.0 / (second - first) / expected_hz - 1.0).abs() < 1e-2, "{sweep:?}");
        assert_close(chirp.value(0.0), 1.0);
        assert_close(chirp.value(duration_s + 1e-9), 1.0);
        assert_close(chirp.value(-0.1), 1.0);
    }
}

fn multisine(lines: Lines) -> ReferenceSpec {
    ReferenceSpec::Multisine { lines, low_hz: 2.0, high_hz: 40.0, period_s: 2.0, rms: 1.5, offset: 10.0 }
}

#[test]
fn truth_multisine_has_its_lines_and_no_others() {
    let step_s = 2.0 / 1000.0;
    for lines in [Lines::All, Lines::Odd, Lines::OddSparse] {
        let reference = compile(&multisine(lines));
        let values: Vec<f64> = (0..1000).map(|i| reference.value(f64::from(i) * step_s) - 10.0).collect();
        assert!((rms(&values) - 1.5).abs() < ROUNDING);
        let amplitudes: Vec<f64> = (1..200).map(|n| amplitude(&values, step_s, f64::from(n) / 2.0)).collect();
        let excited: Vec<usize> = (1..200).filter(|&n| amplitudes[n - 1] > ROUNDING).collect();
        // 2 to 40 Hz at two lines per hertz.
        let all: Vec<usize> = (4..=80).collect();
        let odd: Vec<usize> = all.iter().copied().filter(|n| n % 2 == 1).collect();
        match lines {
            Lines::All => assert_eq!(excited, all),
            Lines::Odd => assert_eq!(excited, odd),
            Lines::OddSparse => {
                assert!(excited.iter().all(|n| odd.contains(n)));
                let kept_per_group: Vec<usize> = odd
                    .chunks_exact(4)
                    .map(|group| group.iter().filter(|n| excited.contains(n)).count())
                    .collect();
                assert!(kept_per_group.iter().all(|&kept| kept == 3), "{kept_per_group:?}");
            }
        }
        let expected = 1.5 * SQRT_2 / (excited.len() as f64).sqrt();
        assert!(excited.iter().all(|&n| (amplitudes[n - 1] - expected).abs() < ROUNDING), "equal amplitudes");
        assert!((reference.value(0.321) - reference.value(0.321 + 2.0 * 1000.0)).abs() < 1e-9, "periodic");
    }
}

/// Cosines in phase have a crest factor of sqrt(2 N) = 12.4 for 77 lines, random ones about sqrt(2
/// ln(points)) = 3.5 or more.
#[test]
fn prop_multisine_has_a_low_crest_factor() {
    let mut crest_factors: Vec<f64> = (0..20)
        .map(|seed| {
            let reference = Reference::new(&multisine(Lines::All), seed, "x").unwrap();
            let values: Vec<f64> = (0..2000).map(|i| reference.value(f64::from(i) * 1e-3) - 10.0).collect();
            values.iter().map(|x| x.abs()).fold(0.0, f64::max) / rms(&values)
        })
        .collect();
    crest_factors.sort_by(f64::total_cmp);
    assert!(crest_factors[19] < 3.3, "{crest_factors:?}");
    assert!(crest_factors[0] < crest_factors[19], "another seed gives other phases");
}

#[test]
fn truth_white_noise_has_its_band_and_power() {
    let (low_hz, high_hz, sigma) = (30.0, 130.0, 2.0);
    let noise = compile(&ReferenceSpec::WhiteNoise { low_hz, high_hz, rms: sigma, offset: 0.0 });
    let (step_s, count) = (1e-3, 40_000_usize);
    let values: Vec<f64> = (0..count).map(|i| noise.value(i as f64 * step_s)).collect();
    // 2 B t = 8000 independent values in 40 s: the variance is known to sqrt(2 / 8000) = 1.6 %, the rms to
    // half of that; 4 sigma.
    assert!((rms(&values) / sigma - 1.0).abs() < 0.032);
    // Mean power per hertz of Hann-windowed segments of 0.4 s, over stretches of 7 Hz. There are 100 segments
    // of 3 bins each, so the power is known to 6 %; 5 sigma.
    let segment = 400;
    let window: Vec<f64> = (0..segment).map(|i| 1.0 - (TAU * i as f64 / segment as f64).cos()).collect();
    let density = |frequency_hz: f64| {
        let powers = values.chunks_exact(segment).map(|chunk| {
            let windowed: Vec<f64> = chunk.iter().zip(&window).map(|(x, w)| x * w).collect();
            [-2.5, 0.0, 2.5]
                .iter()
                .map(|shift| amplitude(&windowed, step_s, frequency_hz + shift).powi(2) / 3.0)
                .sum::<f64>()
        });
        // A window of power 1.5 over 0.4 s.
        powers.sum::<f64>() / (count / segment) as f64 * 0.4 / (2.0 * 1.5)
    };
    let flat = sigma * sigma / (high_hz - low_hz);
    for inside_hz in [45.0, 60.0, 80.0, 100.0, 115.0] {
        assert!(
            (density(inside_hz) / flat - 1.0).abs() < 0.3,
            "{inside_hz} Hz: {}",
            density(inside_hz) / flat
        );
    }
    // Ten hertz beyond the edges the Hann window's pulse is down by 30 dB.
    for outside_hz in [10.0, 18.0, 142.0, 200.0, 400.0] {
        assert!(density(outside_hz) / flat < 1e-3, "{outside_hz} Hz: {}", density(outside_hz) / flat);
    }
}

/// Draws are kept in blocks of 64, 16 384 in all. The slope of noise up to 100 Hz is 2 pi 100 / sqrt(3) rms a
/// second, so values 1 us apart differ by 4e-4; 12 sigma. Draws out of place differ by about 1.
#[test]
fn prop_white_noise_has_no_step_where_kept_draws_begin_or_end() {
    let noise = compile(&ReferenceSpec::WhiteNoise { low_hz: 0.0, high_hz: 100.0, rms: 1.0, offset: 0.0 });
    for border_s in [-0.01, 0.0, 0.63, 0.64, 0.65, 163.83, 163.84, 163.85] {
        let [before, after] = [-5e-7, 5e-7].map(|apart| noise.value(border_s + apart));
        assert!((after - before).abs() < 5e-3, "{border_s} s: {before} and {after}");
    }
}

#[test]
fn truth_prbs_autocorrelation() {
    let (order, clock_period_s, amplitude) = (7, 0.002, 3.0);
    let prbs = compile(&ReferenceSpec::Prbs { order, clock_period_s, amplitude, offset: 0.5 });
    let length = 127;
    // Samples at the chip boundaries; in floating point some of them are slightly before the boundary.
    let chips: Vec<f64> =
        (0..3 * length).map(|i| (prbs.value(i as f64 * clock_period_s) - 0.5) / amplitude).collect();
    assert!(chips.iter().all(|chip| (chip.abs() - 1.0).abs() < ROUNDING));
    for shift in 0..length {
        let product: f64 = (0..length).map(|i| chips[i] * chips[i + shift]).sum();
        assert_close(product, if shift == 0 { length as f64 } else { -1.0 });
    }
    assert_close(prbs.value(0.9 * clock_period_s), prbs.value(0.0));
}

#[test]
fn prop_values_depend_on_time_seed_and_name_only() {
    let noise = ReferenceSpec::WhiteNoise { low_hz: 0.0, high_hz: 100.0, rms: 1.0, offset: 0.0 };
    let prbs = ReferenceSpec::Prbs { order: 9, clock_period_s: 1e-3, amplitude: 1.0, offset: 0.0 };
    for spec in [noise, multisine(Lines::OddSparse), prbs] {
        let reference = compile(&spec);
        let times: Vec<f64> = (0..200).map(|i| f64::from(i) * 3.7e-3).collect();
        let forward: Vec<f64> = times.iter().map(|&t| reference.value(t)).collect();
        let mut backward: Vec<f64> = times.iter().rev().map(|&t| reference.value(t)).collect();
        backward.reverse();
        assert_eq!(forward, backward);
        let of = |seed, name| -> Vec<f64> {
            let reference = Reference::new(&spec, seed, name).unwrap();
            times.iter().map(|&t| reference.value(t)).collect()
        };
        assert_eq!(forward, of(5, "controllers.force"));
        assert_ne!(forward, of(6, "controllers.force"));
        assert_ne!(forward, of(5, "controllers.other"));
    }
}

#[test]
fn prop_mistakes_are_refused() {
    let refused = |spec: &ReferenceSpec| Reference::new(spec, 0, "r").unwrap_err();
    assert_eq!(refused(&ReferenceSpec::Steps(vec![])), ControlError::EmptyReference { kind: "steps" });
    let back = ReferenceSpec::PiecewiseLinear(vec![(0.0, 1.0), (2.0, 1.0), (1.0, 1.0)]);
    assert_eq!(refused(&back), ControlError::TimesNotIncreasing { index: 2, time_s: 1.0, previous_s: 2.0 });
    let uneven = ReferenceSpec::Table {
        times_s: vec![0.0, 1.0],
        values: vec![1.0],
        between: Between::Hold,
        offset: 0.0,
    };
    assert_eq!(refused(&uneven), ControlError::TableLengths { times: 2, values: 1 });
    let between_lines = ReferenceSpec::Multisine {
        lines: Lines::Odd,
        low_hz: 1.1,
        high_hz: 1.9,
        period_s: 1.0,
        rms: 1.0,
        offset: 0.0,
    };
    assert_eq!(refused(&between_lines), ControlError::NoLines { period_s: 1.0, low_hz: 1.1, high_hz: 1.9 });
    let no_band = ReferenceSpec::WhiteNoise { low_hz: 9.0, high_hz: 9.0, rms: 1.0, offset: 0.0 };
    assert_eq!(
        refused(&no_band),
        ControlError::TooLarge {
            key: "reference.band".into(),
            value: 9.0,
            bound: 9.0,
            why: "the upper edge"
        }
    );
    let long = ReferenceSpec::Prbs { order: 40, clock_period_s: 1e-3, amplitude: 1.0, offset: 0.0 };
    assert_eq!(refused(&long), ControlError::PrbsOrder { order: 40, min: 2, max: 18 });
}
