//! The law as a linear system against the controller that it describes.

use feeler_control::{
    AdmittanceGains, Controller, ControllerSpec, ForceGains, ImpedanceGains, Inputs, Law, LeadSpec,
    LinearLaw, LowPassSpec, NotchSpec, PositionGains, Stream,
};

const PERIOD_S: f64 = 1e-3;

fn outputs(law: &LinearLaw, inputs: &[[f64; 3]]) -> Vec<f64> {
    let dot = |row: &[f64], x: &[f64]| row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
    let mut x = vec![0.0; law.c.len()];
    let mut step = |input: &[f64; 3]| {
        let u = dot(&law.c, &x) + dot(&law.d, input);
        x = law.a.iter().zip(&law.b).map(|(a, b)| dot(a, &x) + dot(b, input)).collect();
        u
    };
    inputs.iter().map(&mut step).collect()
}

fn laws() -> Vec<(ControllerSpec, bool, usize)> {
    let new = |law| ControllerSpec::new(law, PERIOD_S);
    let p = ForceGains { feed_forward: 1.0, kp: 2.0, ..ForceGains::default() };
    let lead = Some(LeadSpec { zero_hz: 20.0, pole_hz: 200.0 });
    let pid = ForceGains { ki: 9.0, kd: 0.01, derivative_filter_s: 3e-3, lead, damping: 20.0, ..p };
    let impedance = ImpedanceGains { stiffness: 500.0, damping: 30.0, force_gain: 1.5 };
    let admittance = AdmittanceGains {
        mass: 2.0,
        damping: 30.0,
        stiffness: 100.0,
        kp: 70.0,
        kd: 3.0,
        velocity_feed_forward: 0.5,
    };
    let position = PositionGains { kp: 90.0, ki: 5.0, damping: 4.0, ..PositionGains::default() };
    let notch = Some(NotchSpec { frequency_hz: 60.0, damping_ratio: 0.4, depth: 0.1 });
    let low_pass = |damping_ratio| Some(LowPassSpec { cutoff_hz: 90.0, damping_ratio });
    // Specs, whether motion is a velocity, states: counted by hand from the difference equations.
    vec![
        (new(Law::OpenLoop), false, 0),
        (new(Law::ExplicitForce(p)), false, 0),
        (new(Law::ExplicitForce(ForceGains { ki: 9.0, ..p })), false, 1),
        (new(Law::ExplicitForce(ForceGains { kd: 0.1, ..p })), false, 1),
        // Integral, last error, derivative, lead, last position.
        (new(Law::ExplicitForce(pid)), false, 5),
        (new(Law::ExplicitForce(pid)), true, 4),
        (ControllerSpec { reading_low_pass: low_pass(None), ..new(Law::ExplicitForce(p)) }, false, 1),
        (ControllerSpec { reading_low_pass: low_pass(Some(0.7)), ..new(Law::ExplicitForce(p)) }, false, 2),
        (ControllerSpec { reading_notch: notch, ..new(Law::ExplicitForce(p)) }, false, 2),
        // Last position and filtered velocity.
        (
            ControllerSpec {
                velocity_filter_s: 2e-3,
                ..new(Law::ExplicitForce(ForceGains { damping: 4.0, ..p }))
            },
            false,
            2,
        ),
        (new(Law::Position(position)), false, 2),
        (new(Law::Impedance(impedance)), false, 2),
        // The velocity sensor is integrated: last reading and position, and the last reference.
        (new(Law::Impedance(impedance)), true, 3),
        (new(Law::Admittance(admittance)), false, 3),
    ]
}

#[test]
fn prop_the_linear_system_is_the_controller() {
    let stream = Stream::new(4, "linear");
    for (spec, motion_is_velocity, order) in laws() {
        let law = spec.linear(motion_is_velocity).unwrap();
        assert_eq!(law.c.len(), order, "{:?}", spec.law);
        // The controller starts settled at its first inputs, the system at zero; both agree for a first
        // sample of zeros.
        let inputs: Vec<[f64; 3]> = (0..300)
            .map(|k| std::array::from_fn(|j| if k == 0 { 0.0 } else { stream.normal_at(3 * k + j as u64) }))
            .collect();
        let expected = outputs(&law, &inputs);
        let mut controller = Controller::<f64>::new(std::slice::from_ref(&spec)).unwrap();
        let scale = expected.iter().fold(0.0_f64, |scale, u| scale.max(u.abs()));
        for (k, (&[reference, reading, motion], u)) in inputs.iter().zip(&expected).enumerate() {
            let sampled = controller.sample(
                k as f64 * PERIOD_S,
                &Inputs { reading, motion, motion_is_velocity },
                reference,
            );
            // Rounding of tens of operations per sample, carried along by the integrals.
            assert!((sampled - u).abs() <= 1e-12 * scale, "{:?} at sample {k}: {sampled}, {u}", spec.law);
        }
    }
}

/// The poles of lead and integral appear in the matrix as in the difference equations.
#[test]
fn truth_an_integral_is_a_pole_at_one() {
    let gains = ForceGains { kp: 1.0, ki: 9.0, ..ForceGains::default() };
    let law = ControllerSpec::new(Law::ExplicitForce(gains), PERIOD_S).linear(false).unwrap();
    let expected = LinearLaw {
        a: vec![vec![1.0]],
        b: vec![[9.0 * PERIOD_S, -9.0 * PERIOD_S, 0.0]],
        c: vec![1.0],
        d: [1.0 + 9.0 * PERIOD_S, -1.0 - 9.0 * PERIOD_S, 0.0],
    };
    assert_eq!(law, expected);
}
