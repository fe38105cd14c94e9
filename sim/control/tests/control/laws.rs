//! Each law against its closed form.

use feeler_catalogue::{Bound, KeyRole, Keyed};
use feeler_control::{
    AdmittanceGains, AntiWindup, ControlError, Controller, ControllerSpec, ForceGains, GainPart,
    ImpedanceGains, Inputs, Law, LeadSpec, PositionGains,
};
use feeler_lanes::Pack;

const PERIOD_S: f64 = 1e-3;

/// Closed forms and recursions differ by rounding over hundreds of operations.
const ROUNDING: f64 = 1e-11;

fn force(gains: ForceGains) -> ControllerSpec {
    ControllerSpec::new(Law::ExplicitForce(gains), PERIOD_S)
}

fn compile(spec: ControllerSpec) -> Controller<f64> {
    Controller::new(&[spec]).expect("the spec is sound")
}

fn reading(reading: f64) -> Inputs<f64> {
    Inputs { reading, ..Inputs::default() }
}

fn assert_close(actual: f64, expected: f64) {
    assert!((actual - expected).abs() <= ROUNDING * expected.abs().max(1.0), "{actual} is not {expected}");
}

#[test]
fn truth_pid_step_response() {
    let (kp, ki, kd, tau, feed_forward) = (0.6, 25.0, 2e-3, 4e-3, 0.3);
    let mut controller = compile(force(ForceGains {
        feed_forward,
        kp,
        ki,
        kd,
        derivative_filter_s: tau,
        ..ForceGains::default()
    }));
    assert_close(controller.sample(0.0, &reading(0.0), 0.0), 0.0);
    let (r, f) = (20.0, 5.0);
    for n in 0..200 {
        let e = r - f;
        let derivative = e / (tau + PERIOD_S) * (tau / (tau + PERIOD_S)).powi(n);
        let expected = feed_forward * r + kp * e + ki * PERIOD_S * f64::from(n + 1) * e + kd * derivative;
        assert_close(controller.sample(f64::from(n + 1) * PERIOD_S, &reading(f), r), expected);
    }
}

#[test]
fn truth_the_law_starts_without_history() {
    let lead = Some(LeadSpec { zero_hz: 10.0, pole_hz: 100.0 });
    let mut controller = compile(force(ForceGains { kp: 2.0, kd: 1.0, lead, ..ForceGains::default() }));
    assert_close(controller.sample(0.0, &reading(-3.0), 4.0), 14.0);
}

#[test]
fn truth_every_gain_is_zero_unless_given() {
    let mut controller = compile(force(ForceGains::default()));
    let inputs = Inputs { reading: 3.0, motion: 0.2, motion_is_velocity: true };
    for k in 0..5 {
        assert_close(controller.sample(f64::from(k) * PERIOD_S, &inputs, 20.0), 0.0);
    }
}

/// Amplitude after many samples of an integral force loop on a stiffness of 1 N/m with `delay` whole samples
/// of delay, excited by 1 N.
fn integral_loop_amplitude(loop_gain: f64, delay: usize) -> f64 {
    let mut controller = compile(force(ForceGains { ki: loop_gain / PERIOD_S, ..ForceGains::default() }));
    let mut pending = vec![0.0; delay + 1];
    let mut amplitude: f64 = 0.0;
    for k in 0..6000_usize {
        // The command in force just before sample k was computed `delay + 1` samples ago.
        let f = pending[k % (delay + 1)];
        pending[k % (delay + 1)] = controller.sample(k as f64 * PERIOD_S, &reading(f), 1.0);
        if k >= 5900 {
            amplitude = amplitude.max((f - 1.0).abs());
        }
    }
    amplitude
}

/// Gain limit of an integral force loop with n samples of delay: `T G k < 2 sin(pi / (2 (2 n + 1)))`; n = 1
/// is Whitney's bound.
#[test]
fn truth_integral_force_loop_limits() {
    for delay in 0..4 {
        let limit = 2.0 * (std::f64::consts::PI / (2.0 * (2.0 * delay as f64 + 1.0))).sin();
        // One per cent from the limit the slowest mode changes by about 0.3 % per sample or more, e^18 over
        // the run.
        assert!(integral_loop_amplitude(0.99 * limit, delay) < 1e-3, "delay {delay}");
        assert!(integral_loop_amplitude(1.01 * limit, delay) > 1e3, "delay {delay}");
    }
}

#[test]
fn truth_damping_differences_a_position_and_takes_a_velocity_as_it_is() {
    let gains = ForceGains { damping: 10.0, ..ForceGains::default() };
    let speed = 0.25;
    let mut by_position = compile(force(gains));
    let mut by_velocity = compile(force(gains));
    let tau = 3e-3;
    let mut filtered = compile(ControllerSpec { velocity_filter_s: tau, ..force(gains) });
    for k in 0..50 {
        let t = f64::from(k) * PERIOD_S;
        let position = Inputs { reading: 0.0, motion: 0.7 + speed * t, motion_is_velocity: false };
        let velocity = Inputs { reading: 0.0, motion: speed, motion_is_velocity: true };
        let expected = if k == 0 { 0.0 } else { -10.0 * speed };
        assert_close(by_position.sample(t, &position, 0.0), expected);
        assert_close(by_velocity.sample(t, &velocity, 0.0), -10.0 * speed);
        let settled = 1.0 - (tau / (tau + PERIOD_S)).powi(k);
        assert_close(filtered.sample(t, &position, 0.0), -10.0 * speed * settled);
    }
}

#[test]
fn truth_position_law_damps_the_measured_velocity_only() {
    let gains = PositionGains { kp: 100.0, damping: 4.0, ..PositionGains::default() };
    let mut controller = compile(ControllerSpec::new(Law::Position(gains), PERIOD_S));
    assert_close(controller.sample(0.0, &reading(0.1), 0.1), 0.0);
    // The reference steps: no kick. Then the axis moves.
    assert_close(controller.sample(PERIOD_S, &reading(0.1), 0.3), 100.0 * 0.2);
    assert_close(
        controller.sample(2.0 * PERIOD_S, &reading(0.102), 0.3),
        100.0 * 0.198 - 4.0 * 0.002 / PERIOD_S,
    );
    let sensed = Inputs { reading: 0.104, motion: 1.5, motion_is_velocity: true };
    assert_close(controller.sample(3.0 * PERIOD_S, &sensed, 0.3), 100.0 * 0.196 - 4.0 * 1.5);
}

#[test]
fn truth_impedance_is_a_spring_and_damper_about_the_reference() {
    let (stiffness, damping, force_gain) = (500.0, 30.0, 2.0);
    let gains = ImpedanceGains { stiffness, damping, force_gain };
    let mut controller = compile(ControllerSpec::new(Law::Impedance(gains), PERIOD_S));
    let (x, v_r, f) = (0.2, 0.5, 7.0);
    for k in 0..20 {
        let t = f64::from(k) * PERIOD_S;
        let f_d = stiffness * (v_r * t - x) + damping * if k == 0 { 0.0 } else { v_r };
        let inputs = Inputs { reading: f, motion: x, motion_is_velocity: false };
        assert_close(controller.sample(t, &inputs, v_r * t), f_d + force_gain * (f_d - f));
    }
}

/// The virtual body's position at the end of each period, through an inner loop of gain 1 on an axis that
/// does not move.
fn admittance_path(gains: AdmittanceGains, error: f64, samples: i32) -> Vec<f64> {
    let gains = AdmittanceGains { kp: 1.0, ..gains };
    let mut controller = compile(ControllerSpec::new(Law::Admittance(gains), PERIOD_S));
    let inputs = Inputs { reading: 2.0, motion: 0.4, motion_is_velocity: false };
    (0..samples).map(|k| controller.sample(f64::from(k) * PERIOD_S, &inputs, 2.0 + error)).collect()
}

#[test]
fn truth_admittance_moves_the_virtual_body_exactly() {
    let e = 3.0;
    let times = |k: usize| (k + 1) as f64 * PERIOD_S;
    let (mass, damping, stiffness): (f64, f64, f64) = (2.0, 20.0, 5e3);
    let (w, zeta) = ((stiffness / mass).sqrt(), damping / (2.0 * (stiffness * mass).sqrt()));
    let w_d = w * (1.0 - zeta * zeta).sqrt();
    let body = AdmittanceGains { mass, damping, stiffness, ..AdmittanceGains::default() };
    for (k, x) in admittance_path(body, e, 400).into_iter().enumerate() {
        let t = times(k);
        let decay = (-zeta * w * t).exp() * ((w_d * t).cos() + zeta * w / w_d * (w_d * t).sin());
        assert_close(x, e / stiffness * (1.0 - decay));
    }
    let mass_and_damper = AdmittanceGains { mass, damping, ..AdmittanceGains::default() };
    for (k, x) in admittance_path(mass_and_damper, e, 400).into_iter().enumerate() {
        let (t, tau) = (times(k), mass / damping);
        assert_close(x, e / damping * (t - tau * (1.0 - (-t / tau).exp())));
    }
    let massless = AdmittanceGains { damping, stiffness, ..AdmittanceGains::default() };
    for (k, x) in admittance_path(massless, e, 40).into_iter().enumerate() {
        assert_close(x, e / stiffness * (1.0 - (-stiffness / damping * times(k)).exp()));
    }
    let damper = AdmittanceGains { damping, ..AdmittanceGains::default() };
    for (k, x) in admittance_path(damper, e, 40).into_iter().enumerate() {
        assert_close(x, e / damping * times(k));
    }
}

/// The virtual body's velocity as command of a velocity source: a massless damper gives `e / B` immediately.
#[test]
fn truth_admittance_velocity_command() {
    let gains = AdmittanceGains { damping: 40.0, velocity_feed_forward: 1.0, ..AdmittanceGains::default() };
    let mut controller = compile(ControllerSpec::new(Law::Admittance(gains), PERIOD_S));
    for k in 0..5 {
        assert_close(controller.sample(f64::from(k) * PERIOD_S, &reading(1.0), 9.0), 8.0 / 40.0);
    }
}

/// Output after 1000 samples of an error of +1 against a limit of 5, then one of -1.
fn after_saturation(anti_windup: AntiWindup) -> f64 {
    let gains = ForceGains { kp: 1.0, ki: 30.0, anti_windup, ..ForceGains::default() };
    let mut controller = compile(ControllerSpec { output_limit: Some(5.0), ..force(gains) });
    for k in 0..1000 {
        controller.sample(f64::from(k) * PERIOD_S, &reading(0.0), 1.0);
    }
    controller.sample(1.0, &reading(0.0), -1.0)
}

#[test]
fn truth_anti_windup_recovers_at_once_where_a_wound_up_integrator_does_not() {
    // Wound up: i = ki e t = 30 after 1 s, so that an error of -1 leaves 30 - 0.03 - 1, far beyond the limit.
    assert_close(after_saturation(AntiWindup::Off), 5.0);
    // Conditional: the integral grew by 0.03 per sample as long as kp e + i stayed within 5: 133 times, to
    // 3.99.
    assert_close(after_saturation(AntiWindup::Conditional), 3.99 - 0.03 - 1.0);
    // Back-calculation settles at ki e = (u - limit) / T_t: u = 5 + 30 T_t, and the remaining integral is u -
    // kp e - ki T e.
    let tracking_time_s = 0.01;
    let kept = 5.0 + 30.0 * tracking_time_s - 1.0 - 0.03;
    assert_close(after_saturation(AntiWindup::BackCalculation { tracking_time_s }), kept - 0.03 - 1.0);
}

#[test]
fn truth_output_is_rounded_and_limited() {
    let spec = ControllerSpec {
        output_resolution: Some(0.25),
        output_limit: Some(1.1),
        ..ControllerSpec::new(Law::OpenLoop, PERIOD_S)
    };
    let mut controller = compile(spec);
    for (wanted, expected, saturated) in [
        (0.1, 0.0, false),
        (0.2, 0.25, false),
        (-0.6, -0.5, false),
        (1.05, 1.0, false),
        (7.0, 1.1, true),
        (-7.0, -1.1, true),
    ] {
        assert_close(controller.sample(0.0, &Inputs::default(), wanted), expected);
        assert_eq!(controller.saturated(), saturated, "{wanted}");
    }
}

#[test]
fn prop_a_reading_that_is_not_a_number_is_not_hidden_by_the_limit() {
    let mut controller = compile(ControllerSpec {
        output_limit: Some(5.0),
        ..force(ForceGains { kp: 1.0, ..ForceGains::default() })
    });
    assert!(controller.sample(0.0, &reading(f64::NAN), 1.0).is_nan());
}

#[test]
fn prop_mistakes_are_refused_with_their_key() {
    let good = force(ForceGains::default());
    let refused = |spec: ControllerSpec| Controller::<f64>::new(&[spec]).unwrap_err();
    assert_eq!(
        refused(ControllerSpec { period_s: 0.0, ..good.clone() }),
        ControlError::OutOfRange { key: "period".into(), value: 0.0, bound: Bound::Within(1e-9, 1e6) }
    );
    assert_eq!(
        refused(ControllerSpec { delay_s: -1e-3, ..good.clone() }),
        ControlError::OutOfRange { key: "delay".into(), value: -1e-3, bound: Bound::Within(0.0, 1e3) }
    );
    let infinite = force(ForceGains { ki: f64::INFINITY, ..ForceGains::default() });
    assert_eq!(
        refused(infinite),
        ControlError::OutOfRange { key: "ki".into(), value: f64::INFINITY, bound: Bound::Any }
    );
    let nothing_virtual = ControllerSpec::new(Law::Admittance(AdmittanceGains::default()), PERIOD_S);
    assert_eq!(
        refused(nothing_virtual),
        ControlError::AdmittanceWithoutMassOrDamping { mass: "mass", damping: "damping" }
    );

    assert_eq!(
        Controller::<Pack<2>>::new(std::slice::from_ref(&good)).unwrap_err(),
        ControlError::LaneCount { lanes: 2, given: 1 }
    );
    let other_law = ControllerSpec::new(Law::OpenLoop, PERIOD_S);
    assert_eq!(
        Controller::<Pack<2>>::new(&[good.clone(), other_law]).unwrap_err(),
        ControlError::LawsDiffer { lane: 1 }
    );
    let other_period = ControllerSpec { period_s: 2e-3, ..good.clone() };
    assert_eq!(
        Controller::<Pack<2>>::new(&[good, other_period]).unwrap_err(),
        ControlError::TimingDiffers { lane: 1 }
    );
}

/// So the gain of a part is unique.
#[test]
fn truth_no_law_has_two_gains_of_one_part() {
    for law in Law::FORMS.iter().map(|form| (form.start)()) {
        for gain in law.gains() {
            let KeyRole::Gain { part, .. } = gain.role else { panic!("{} is not a gain", gain.key.name) };
            let found = law.gain(part).unwrap().key.name;
            assert!(part == GainPart::Other || found == gain.key.name, "{}: {found}", law.name());
        }
    }
}
