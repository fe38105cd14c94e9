//! Responses of readings to references, with the loop closed.

use crate::common::{control, force_loop, machine};
use feeler_analysis::{ClosedLoop, ControlLoop, StepResponse, View};
use feeler_control::reference::ChirpSweep;
use feeler_control::{
    AdmittanceGains, ForceGains, ImpedanceGains, Law, LeadSpec, PositionGains, ReferenceSpec,
};
use feeler_engine::{Scenario, Simulation, Trace};
use feeler_plant::description::Spring;

/// Low frequency is 1e-3 Hz and the bandwidth about 30 Hz. The error is the square of their ratio, with a
/// margin.
const LOW_IS_NOT_ZERO: f64 = 1e-8;
/// A sampled loop lags by a period and a half at most, 0.015 ms. That is 3e-3 rad at 30 Hz, times a factor
/// for a lead and a lightly damped loop.
const FAST_SAMPLING: f64 = 0.02;

#[test]
fn truth_bandwidth_of_a_mass_on_a_stiffness() {
    let (kp, k, b) = (0.5, 2e5, 900.0);
    let mut scenario = force_loop(kp, 0.0);
    scenario.machine.springs.insert(
        "transmission".into(),
        Spring { rigid: true, ..scenario.machine.springs["transmission"].clone() },
    );
    scenario.machine.springs["guide"].damping_n_s_per_m = b;
    scenario.machine.contacts["tool"].damping_n_s_per_m = 0.0;
    // kp k / (m s^2 + b s + (1 + kp) k), down to 1 / sqrt 2 of its value at rest.
    let m = 12.0;
    let w0_squared = (1.0 + kp) * k / m;
    let bend = 1.0 - b * b / (2.0 * m * m * w0_squared);
    let expected_hz = (w0_squared * (bend + (bend * bend + 1.0).sqrt())).sqrt() / std::f64::consts::TAU;
    let found_hz = ClosedLoop::continuous(&ControlLoop::new(&scenario, &View::CLAMPED).unwrap(), 0)
        .unwrap()
        .unwrap()
        .bandwidth_hz()
        .unwrap()
        .unwrap();
    assert!((found_hz / expected_hz - 1.0).abs() < LOW_IS_NOT_ZERO, "{found_hz} {expected_hz}");
}

#[test]
fn prop_every_law_on_paper_is_its_fast_sampled_one() {
    let lead = Some(LeadSpec { zero_hz: 30.0, pole_hz: 200.0 });
    let pid = ForceGains {
        feed_forward: 0.7,
        kp: 0.2,
        ki: 3.0,
        kd: 1e-3,
        derivative_filter_s: 2e-3,
        damping: 20.0,
        lead,
        ..ForceGains::default()
    };
    let virtual_body = AdmittanceGains {
        mass: 5.0,
        damping: 300.0,
        stiffness: 1e3,
        kp: 1e4,
        kd: 50.0,
        velocity_feed_forward: 10.0,
    };
    let laws = [
        (Law::ExplicitForce(pid), "force"),
        (
            Law::Position(PositionGains {
                kp: 2e4,
                ki: 100.0,
                kd: 200.0,
                damping: 50.0,
                ..PositionGains::default()
            }),
            "encoder",
        ),
        (Law::Impedance(ImpedanceGains { stiffness: 1e4, damping: 100.0, force_gain: 0.2 }), "force"),
        (Law::Admittance(virtual_body), "force"),
        (Law::Admittance(AdmittanceGains { mass: 0.0, ..virtual_body }), "force"),
    ];
    for (law, reads) in laws {
        let name = law.name();
        let mut user = control(law, reads, 1e-5, 0.0);
        user.motion = Some("encoder".into());
        let controllers = [("only".to_string(), user)].into_iter().collect();
        let scenario = Scenario { machine: machine(), controllers, ..force_loop(0.0, 0.0) };
        let whole = ControlLoop::new(&scenario, &View::CLAMPED).unwrap();
        let sampled = ClosedLoop::sampled(&whole, 0).unwrap().unwrap();
        let continuous = ClosedLoop::continuous(&whole, 0).unwrap().unwrap();
        for frequency_hz in [0.3, 3.0, 15.0, 30.0] {
            let (a, b) = (sampled.at(frequency_hz).unwrap(), continuous.at(frequency_hz).unwrap());
            assert!((a - b).norm() < FAST_SAMPLING * b.norm(), "{name} at {frequency_hz} Hz: {a} {b}");
        }
    }
}

/// After this time the slowly settling part of the response is below 1e-6 of the response.
const SETTLED_S: f64 = 4.0;

#[test]
fn truth_at_the_bandwidth_a_simulated_sine_is_3_db_down() {
    let mut scenario = force_loop(0.3, 0.4e-3);
    let whole = ControlLoop::new(&scenario, &View::CLAMPED).unwrap();
    let bandwidth_hz = whole.bandwidth_hz(0).unwrap().unwrap();
    let closed = ClosedLoop::sampled(&whole, 0).unwrap().unwrap();
    let at_rest = closed.at(1e-3).unwrap().norm();
    // A whole number of samples in a whole number of periods: the sum over them is the amplitude, whatever
    // the phase.
    let frequency_hz = 0.1 * (10.0 * bandwidth_hz).round();
    let expected = closed.at(frequency_hz).unwrap().norm();
    assert!((expected / at_rest - std::f64::consts::FRAC_1_SQRT_2).abs() < 0.01);
    let duration_s = SETTLED_S + 10.0;
    let (start_hz, end_hz) = (frequency_hz, frequency_hz);
    scenario.controllers["force"].spec.reference = ReferenceSpec::Chirp {
        sweep: ChirpSweep::Linear,
        amplitude: 1.0,
        start_hz,
        end_hz,
        duration_s,
        offset: 0.0,
    };
    scenario.run.duration_s = duration_s;
    scenario.run.record = vec!["tool.spring_force".parse().unwrap()];
    let program = feeler_engine::Program::new(&scenario).unwrap();
    let mut trace = Trace::new(program.record_names());
    Simulation::<f64>::new(vec![program]).unwrap().run(&mut trace).unwrap();
    let (mut re, mut im, mut count) = (0.0, 0.0, 0.0);
    for (t, f) in
        trace.t_s.iter().zip(&trace.columns[0]).filter(|(t, _)| **t >= SETTLED_S && **t < duration_s - 1e-9)
    {
        let (sin, cos) = (std::f64::consts::TAU * frequency_hz * t).sin_cos();
        (re, im, count) = (re + f * cos, im + f * sin, count + 1.0);
    }
    let amplitude = 2.0 * f64::hypot(re, im) / count;
    assert!((amplitude / expected - 1.0).abs() < 1e-6, "{amplitude} {expected}");
}

/// The linear machine stepped by samples equals the simulated one to machine precision. A few hundred
/// products of exponentials give 1e-10 of the step.
const ROUNDING: f64 = 1e-9;

#[test]
fn truth_a_step_by_theory_is_that_of_the_simulation() {
    // The second has more samples of delay than the limit for states.
    for (kp, delay_s) in [(0.3, 4e-4), (0.02, 2.05e-2)] {
        let mut scenario = force_loop(kp, delay_s);
        scenario.controllers["force"].spec.reference = ReferenceSpec::Constant(1.0);
        scenario.run.duration_s = 0.2;
        scenario.run.record_rate_hz = Some(1000.0);
        scenario.run.record = vec!["force.reading".parse().unwrap()];
        let program = feeler_engine::Program::new(&scenario).unwrap();
        let mut record = Trace::new(program.record_names());
        let mut simulation = Simulation::<f64>::new(vec![program]).unwrap();
        simulation.run_to(0.2, &mut record).unwrap();
        let simulated = record.column("force.reading").unwrap();
        let whole = ControlLoop::new(&scenario, &View::CLAMPED).unwrap();
        let step = StepResponse::new(&whole, 0, 0.2).unwrap().unwrap();
        assert!(step.values.len() > 200 && simulated.len() > 190, "{}", simulated.len());
        for (k, (theory, run)) in step.values.iter().zip(simulated).enumerate() {
            assert!((theory - run).abs() < ROUNDING, "sample {k}: {theory} {run}");
        }
    }
}
