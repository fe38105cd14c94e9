//! The manual's table on how a controller is discretised, row by row against the controller.

use std::f64::consts::{PI, TAU};

use feeler_control::filter::Section;
use feeler_control::{Controller, ControllerSpec, ForceGains, ImpedanceGains, Inputs, Law, Stream};
use num_complex::Complex;

const MANUAL: &str = include_str!("../../../../docs/format.md");
const PERIOD_S: f64 = 1e-3;
const SAMPLES: usize = 300;
/// Roundings of a few operations a sample over 300 samples, of the largest output.
const ROUNDING: f64 = 1e-12;

/// A filter as a function of `s`.
type OnPaper<'a> = &'a dyn Fn(Complex<f64>) -> Complex<f64>;

/// Asserts that the manual's row of this part contains `how`.
fn states(part: &str, how: &str) {
    let table = MANUAL.split("### How a controller is discretised").nth(1).expect("the table");
    let row = table.lines().find(|line| line.starts_with(&format!("| {part} |")));
    assert!(row.is_some_and(|row| row.contains(how)), "{part}: {row:?}");
}

/// Outputs of a controller for random inputs; `fed` sets the only input that is not zero.
fn sampled(spec: &ControllerSpec, signal: &[f64], fed: impl Fn(f64) -> Inputs<f64>) -> Vec<f64> {
    let mut controller = Controller::<f64>::new(std::slice::from_ref(spec)).expect("the spec is sound");
    let outputs = signal.iter().enumerate();
    outputs.map(|(n, &x)| controller.sample(n as f64 * PERIOD_S, &fed(x), 0.0)).collect()
}

fn same(part: &str, sampled: &[f64], expected: &[f64]) {
    let scale = expected.iter().fold(0.0_f64, |scale, u| scale.max(u.abs()));
    assert!(scale > 0.0, "{part}");
    for (n, (is, wanted)) in sampled.iter().zip(expected).enumerate() {
        assert!((is - wanted).abs() <= ROUNDING * scale, "{part}, sample {n}: {is}, not {wanted}");
    }
}

#[test]
fn truth_the_difference_equations_of_the_manual_are_those_that_run() {
    let stream = Stream::new(9, "manual");
    let x: Vec<f64> = (0..SAMPLES as u64).map(|n| stream.normal_at(n)).collect();
    let force = |gains| ControllerSpec::new(Law::ExplicitForce(gains), PERIOD_S);
    let reading = |x: f64| Inputs { reading: -x, ..Inputs::default() };
    let position = |x: f64| Inputs { motion: x, ..Inputs::default() };
    // `y[n]` of a rule that takes `y[n-1]`, `x[n]` and `x[n-1]`, from `first` on.
    let run = |first: f64, rule: &dyn Fn(f64, f64, f64) -> f64| {
        let mut y = vec![first];
        for n in 1..SAMPLES {
            y.push(rule(y[n - 1], x[n], x[n - 1]));
        }
        y
    };
    let times = |factor: f64, y: Vec<f64>| y.into_iter().map(|y| factor * y).collect::<Vec<f64>>();

    states("integral", "`i[n] = i[n-1] + ki T e[n]`");
    let ki = 9.0;
    let found = sampled(&force(ForceGains { ki, ..ForceGains::default() }), &x, reading);
    same("integral", &found, &run(ki * PERIOD_S * x[0], &|i, e, _| i + ki * PERIOD_S * e));

    states("derivative", "`d[n] = (tau d[n-1] + e[n] - e[n-1]) / (tau + T)`, times `kd`");
    let (kd, tau) = (0.1, 3e-3);
    let gains = ForceGains { kd, derivative_filter_s: tau, ..ForceGains::default() };
    let rule = |y: f64, now: f64, last: f64| (tau * y + now - last) / (tau + PERIOD_S);
    same("derivative", &sampled(&force(gains), &x, reading), &times(kd, run(0.0, &rule)));

    states("velocity of a position sensor", "`v[n] = (tau v[n-1] + x[n] - x[n-1]) / (tau + T)`; 0 at");
    let damped = force(ForceGains { damping: 4.0, ..ForceGains::default() });
    let spec = ControllerSpec { velocity_filter_s: tau, ..damped };
    same("velocity", &sampled(&spec, &x, position), &times(-4.0, run(0.0, &rule)));

    states("position of a velocity sensor", "`x[n] = x[n-1] + T (v[n] + v[n-1]) / 2`; 0 at");
    let gains = ImpedanceGains { stiffness: 500.0, damping: 0.0, force_gain: 0.0 };
    let velocity = |x: f64| Inputs { motion: x, motion_is_velocity: true, ..Inputs::default() };
    let found = sampled(&ControllerSpec::new(Law::Impedance(gains), PERIOD_S), &x, velocity);
    let path = run(0.0, &|x, now, last| x + PERIOD_S * (now + last) / 2.0);
    same("position", &found, &times(-500.0, path));
}

/// The transform takes `s` to `g (1 - z^-1) / (1 + z^-1)`, with `g = w / tan(w T / 2)` if it is prewarped at
/// `w`, else `2 / T`.
#[test]
fn truth_the_filters_of_the_manual_are_those_that_run() {
    const BILINEAR: &str = "bilinear transform";
    let at = |hz: f64| TAU * hz;
    let warped = |hz: f64| at(hz) / (PI * hz * PERIOD_S).tan();
    let (zeta, depth) = (0.4, 0.1);
    let first = |s: Complex<f64>| 1.0 / (1.0 + s / at(90.0));
    let quadratic = |s: Complex<f64>, zeta: f64| s * s + 2.0 * zeta * at(90.0) * s + at(90.0).powi(2);
    let second = |s: Complex<f64>| at(90.0).powi(2) / quadratic(s, zeta);
    let notch = |s: Complex<f64>| quadratic(s, depth * zeta) / quadratic(s, zeta);
    let lead = |s: Complex<f64>| (1.0 + s / at(15.0)) / (1.0 + s / at(90.0));
    let rows: [(&str, Section<f64>, f64, OnPaper<'_>); 4] = [
        (
            "`low_pass` of a controller, first order",
            Section::low_pass_first(90.0, PERIOD_S),
            warped(90.0),
            &first,
        ),
        (
            "`low_pass` of a controller, second order",
            Section::low_pass_second(90.0, zeta, PERIOD_S),
            warped(90.0),
            &second,
        ),
        ("`notch`", Section::notch(90.0, zeta, depth, PERIOD_S), warped(90.0), &notch),
        ("`lead`", Section::lead(15.0, 90.0, PERIOD_S), 2.0 / PERIOD_S, &lead),
    ];
    for (part, section, g, on_paper) in rows {
        states(part, BILINEAR);
        states(part, if part == "`lead`" { "not prewarped" } else { "prewarped at" });
        for hz in [3.0, 40.0, 90.0, 233.0, 480.0] {
            let back = Complex::cis(-at(hz) * PERIOD_S);
            let expected = on_paper(g * (1.0 - back) / (1.0 + back));
            let [re, im] = section.response(hz, PERIOD_S);
            let off = (Complex::new(re, im) - expected).norm();
            // Near half the sample rate, 480 Hz of 500, `1 + z^-1` loses a digit.
            assert!(off < 1e-11 * expected.norm().max(1.0), "{part} at {hz} Hz: {off:e}");
        }
    }
}
