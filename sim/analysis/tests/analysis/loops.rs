//! Sampled and continuous loops.

use crate::common::{control, force_loop, machine, spring};
use feeler_analysis::{AnalysisError, ControlLoop, Limit, ModeClass, Relief, Request, SampledLoop, View, analyze};
use feeler_control::{AdmittanceGains, ForceGains, ImpedanceGains, Law, LeadSpec, LowPassSpec, PositionGains};
use feeler_engine::{Program, RunSettings, Scenario, Simulation, Trace};
use feeler_lti::LoopTransfer;
use feeler_plant::description::{Body, GROUND, LowPass};
use nalgebra::DVector;

/// Two ways to the same edge, both good to about 1e-11.
const SAME_EDGE: f64 = 1e-9;

/// The largest stable gain; not a number where there is none to be had.
fn bands(scenario: &Scenario, key: &str) -> f64 {
    let found = ControlLoop::new(scenario, &View::CLAMPED).and_then(|whole| whole.sampled_bands(key));
    found.map_or(f64::NAN, |bands| bands.first_upper())
}

#[test]
fn truth_it_does_not_matter_where_in_the_loop_a_delay_is() {
    let late_controller = bands(&force_loop(0.1, 1.3e-3), "kp");
    let mut late_sensor = force_loop(0.1, 0.0);
    late_sensor.machine.sensors["force"].delay_s = 1.3e-3;
    let mut both = force_loop(0.1, 0.9e-3);
    both.machine.sensors["force"].delay_s = 0.4e-3;
    for other in [bands(&late_sensor, "kp"), bands(&both, "kp")] {
        assert!((other / late_controller - 1.0).abs() < SAME_EDGE, "{other} {late_controller}");
    }
    // Nor when the first sample is.
    let mut shifted = force_loop(0.1, 1.3e-3);
    shifted.controllers["force"].spec.offset_s = 0.37e-3;
    assert!((bands(&shifted, "kp") / late_controller - 1.0).abs() < SAME_EDGE);
}

#[test]
fn truth_gain_margin_and_stable_gain_are_two_views_of_one_edge() {
    let scenario = force_loop(0.2, 0.6e-3);
    let whole = ControlLoop::new(&scenario, &View::CLAMPED).unwrap();
    let open = SampledLoop::new(&whole).unwrap().open_loop(0).unwrap();
    let margins = LoopTransfer::discrete(&open).unwrap().margins().unwrap();
    let edge = bands(&scenario, "kp");
    assert!((margins.smallest_increase().unwrap().factor * 0.2 / edge - 1.0).abs() < SAME_EDGE);
}

#[test]
fn regress_joint_damping_that_is_zero_has_its_motion_sensor_when_it_is_varied() {
    let asked = |scenario: &Scenario| {
        let request = Request { gain: Some("controllers.force.damping".into()), view: View::CLAMPED, ..Request::default() };
        let gain = analyze(scenario, &request).unwrap().gain.unwrap();
        [gain.sampled.stable[1].unwrap(), gain.continuous.unwrap().edge_hz.unwrap_or(0.0)]
    };
    let left_out = force_loop(0.3, 0.0);
    let mut named = left_out.clone();
    named.controllers["force"].motion = Some("encoder".into());
    let mut in_use = left_out.clone();
    let Law::ExplicitForce(gains) = &mut in_use.controllers["force"].spec.law else { unreachable!() };
    gains.damping = 100.0;
    let [expected, edge_hz] = asked(&named);
    for scenario in [left_out, in_use] {
        let [largest, at_hz] = asked(&scenario);
        assert!((largest / expected - 1.0).abs() < SAME_EDGE && (at_hz - edge_hz).abs() <= SAME_EDGE * edge_hz);
    }
}

#[test]
fn regress_what_no_ingredient_s_absence_makes_stable_is_not_called_unlimited() {
    let mut scenario = force_loop(0.3, 0.0);
    let Law::ExplicitForce(gains) = &mut scenario.controllers["force"].spec.law else { unreachable!() };
    // Far beyond what the axis bears of an integral at any proportional gain.
    gains.ki = 1e5;
    let request = Request { gain: Some("kp".into()), view: View::CLAMPED, ..Request::default() };
    let report = analyze(&scenario, &request).unwrap();
    assert!(report.gain.unwrap().sampled.all.bands.is_empty());
    let without = report.waterfall.unwrap().without;
    let stiff = without.iter().find(|(name, _)| name == "springs.transmission").unwrap();
    assert_eq!(stiff.1, Relief::NoneEither);
    assert_eq!(serde_json::to_value(stiff.1).unwrap(), "none");
}

/// Lifted loops of every law, several rates, delays and filters: what the matrix says of a state after a common period, the engine does.
#[test]
fn prop_one_period_of_the_lifted_loop_is_one_period_of_the_simulation() {
    let force = Law::ExplicitForce(ForceGains {
        kp: 0.2,
        ki: 3.0,
        kd: 1e-4,
        damping: 20.0,
        derivative_filter_s: 2e-3,
        lead: Some(LeadSpec { zero_hz: 30.0, pole_hz: 200.0 }),
        ..ForceGains::default()
    });
    let laws = [
        (force, "force"),
        (Law::Position(PositionGains { kp: 2e4, kd: 200.0, ..PositionGains::default() }), "encoder"),
        (Law::Impedance(ImpedanceGains { stiffness: 1e4, damping: 100.0, force_gain: 0.2 }), "force"),
        (
            Law::Admittance(AdmittanceGains { mass: 5.0, damping: 300.0, stiffness: 1e3, kp: 1e4, kd: 50.0, velocity_feed_forward: 0.0 }),
            "force",
        ),
    ];
    for (law, reads) in laws {
        let mut machine = machine();
        machine.sensors["force"].low_pass = Some(LowPass::SecondOrder { corner_hz: 150.0, damping_ratio: 0.7 });
        let mut main = control(law, reads, 2e-3, 0.7e-3);
        main.spec.reading_low_pass = Some(LowPassSpec { cutoff_hz: 90.0, damping_ratio: None });
        let damper = control(Law::ExplicitForce(ForceGains { damping: 30.0, ..ForceGains::default() }), "force", 3e-3, 0.0);
        let controllers = [("main".to_string(), main), ("damper".to_string(), damper)].into_iter().collect();
        let periods = 5;
        let run =
            RunSettings { duration_s: f64::from(periods) * 6e-3, record: vec!["tip.position".parse().unwrap()], ..RunSettings::default() };
        let scenario = Scenario { machine, controllers, run };
        let whole = ControlLoop::new(&scenario, &View::CLAMPED).unwrap();
        let lifted = SampledLoop::new(&whole).unwrap();
        assert!((lifted.common_period_s() - 6e-3).abs() < 1e-15);

        let program = Program::new(&scenario).unwrap();
        let states = program.motion().layout().states();
        let mut simulation = Simulation::<f64>::new(vec![program]).unwrap();
        // Only speeds at the start: controllers begin settled at their first readings, which then are zero as in the lifted loop.
        let mut start = vec![0.0; states];
        start[2] = 0.3;
        start[3] = -0.2;
        simulation.set_state(0, &start).unwrap();
        simulation.run_to(f64::from(periods) * 6e-3 - 1e-9, &mut Trace::new(&["tip.position".into()])).unwrap();
        let a = lifted.closed_loop().unwrap();
        let mut x = DVector::zeros(a.nrows());
        x.rows_mut(0, states).copy_from_slice(&start);
        for _ in 0..periods {
            x = &a * x;
        }
        let got = simulation.state(0);
        let size = got[..2].iter().fold(0.0_f64, |s, v| s.max(v.abs()));
        for i in 0..2 {
            // The simulation stops a nanosecond short of the next sample, at speeds below 1 m/s.
            assert!((got[i] - x[i]).abs() < 1e-9 + 1e-6 * size, "{}: coordinate {i}: {} {}", reads, got[i], x[i]);
        }
    }
}

#[test]
fn truth_report_of_the_flexible_axis_has_the_contract_s_shape() {
    let report = analyze(&force_loop(0.3, 0.0), &Request { view: View::CLAMPED, ..Request::default() }).unwrap();
    let json: serde_json::Value = serde_json::to_value(&report).unwrap();
    for key in ["poles", "zeros", "poles_hz", "zeros_hz", "modes", "gain", "margins", "limit"] {
        assert!(!json[key].is_null(), "{key}");
    }
    assert_eq!(json["gain"]["key"], "controllers.force.kp");
    assert_eq!(json["modes"][1]["class"], "noncolocated");
    assert_eq!(json["gain"]["continuous"]["stable"][0], 0.0);
    assert!((json["gain"]["sampled"]["stable"][1].as_f64().unwrap() - 1.5068).abs() < 1e-4);
    assert_eq!(report.modes[1].class, ModeClass::Noncolocated);
    assert!((report.modes[1].phase_change_deg + 180.0).abs() < 1e-12);
    assert_eq!(report.limit, Some(Limit::Sampling));
    // The branch that becomes unstable starts at the rigid-body motion, which the flexible mode robs of its phase (the paper's Fig. 8).
    assert_eq!(report.gain.unwrap().continuous.unwrap().edge_mode, Some(0));
}

/// A damped mode's phase is at its end value to 2 zeta f0 / f: at a thousand times the highest mode, 1e-3 degrees of it is left.
const PHASE_LEFT_DEG: f64 = 0.1;

#[test]
fn truth_what_modes_cost_for_good_is_what_the_phase_loses() {
    let mut scenario = force_loop(0.1, 0.0);
    let machine = &mut scenario.machine;
    for (name, mass_kg) in [("base", 180.0), ("workpiece", 3.0)] {
        machine.bodies.insert(name.into(), Body { mass_kg, ..Body::default() });
    }
    machine.springs.insert("mount".into(), spring(GROUND, "base", 1.023e6, 814.0));
    machine.springs.insert("fixture".into(), spring("base", "workpiece", 1.5e6, 150.0));
    machine.springs["guide"].between = ["base".into(), "motor".into()];
    machine.contacts["tool"].between = ["tip".into(), "workpiece".into()];
    machine.actuators["drive"].reacts_on = "base".into();
    let report = analyze(&scenario, &Request { view: View::CLAMPED, ..Request::default() }).unwrap();
    let classes: Vec<ModeClass> = report.modes.iter().map(|mode| mode.class).collect();
    // The transmission turns what lies above it; the workpiece's mode, noncolocated like it, comes with the zeros between both.
    assert_eq!(classes, [ModeClass::Colocated, ModeClass::Colocated, ModeClass::Noncolocated, ModeClass::Noncolocated]);
    let lost: Vec<f64> = report.modes.iter().map(|mode| mode.phase_change_deg).collect();
    assert_eq!(lost.iter().map(|v| v.round() as i32).collect::<Vec<_>>(), [0, -180, -180, 0]);
    let plant = feeler_analysis::LinearMachine::new(&scenario.machine, &View::CLAMPED).unwrap();
    let channel = plant.channel(&report.input.parse().unwrap(), &report.output.parse().unwrap()).unwrap();
    // The transmission's damping is a real zero, 90 degrees of lead in the end.
    assert_eq!(report.zeros.iter().filter(|zero| zero[1].abs() < 1e-9).count(), 1);
    let frequencies: Vec<f64> = (0..40_000).map(|i| 0.1 * 10_f64.powf(7.0 * f64::from(i) / 40_000.0)).collect();
    let phase = feeler_lti::unwrapped_phase_rad(&channel.frequency_response(&frequencies).unwrap());
    let turned = (phase[phase.len() - 1] - phase[0]).to_degrees();
    assert!((turned - 90.0 - lost.iter().sum::<f64>()).abs() < PHASE_LEFT_DEG, "{turned}");
}

#[test]
fn truth_a_free_machine_is_looked_at_where_it_would_touch() {
    let mut scenario = force_loop(0.1, 0.0);
    scenario.controllers.clear();
    let report = analyze(&scenario, &Request { view: View::FREE, ..Request::default() }).unwrap();
    assert_eq!((report.input.as_str(), report.output.as_str()), ("drive.command", "tip.acceleration"));
    assert!(!report.poles.is_empty());
}

#[test]
fn truth_a_drive_that_saturates_limits_the_bandwidth() {
    let mut scenario = force_loop(0.6, 0.0);
    scenario.machine.actuators["drive"].limit_n = Some(8.0);
    scenario.controllers["force"].spec.reference = feeler_control::ReferenceSpec::Constant(20.0);
    let report = analyze(&scenario, &Request { view: View::CLAMPED, ..Request::default() }).unwrap();
    assert_eq!(report.limit, Some(Limit::Saturation), "{:?}", report.waterfall);
}

#[test]
fn truth_sensitivities_of_a_rigid_axis_follow_its_scaling() {
    let whole = ControlLoop::new(&force_loop(0.3, 0.0), &View::CLAMPED).unwrap();
    let all = whole.sensitivities("kp").unwrap();
    let of = |key: &str| all.iter().find(|s| s.key == key).unwrap();
    // More contact stiffness means more loop gain for the same kp, so less of it is stable.
    assert!(of("contacts.tool.stiffness").largest_gain_relative < -0.3);
    assert!(of("springs.transmission.stiffness").largest_gain_relative > 0.0);
    assert_eq!(all.len(), 7);
}

#[test]
fn truth_unknown_names_are_told() {
    let whole = ControlLoop::new(&force_loop(0.1, 0.0), &View::CLAMPED).unwrap();
    assert!(matches!(whole.sampled_bands("controllers.fource.kp"), Err(AnalysisError::NoController { .. })));
    assert!(matches!(whole.sampled_bands("stiffness"), Err(AnalysisError::NoGain { .. })));
}
