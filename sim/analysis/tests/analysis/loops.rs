//! Sampled and continuous loops.

use crate::common::{control, force_loop, machine, sensor, spring};
use feeler_analysis::{
    AnalysisError, ControlLoop, Limit, ModeClass, RankedBy, Relief, Request, SampledLoop, View, Workers,
    analyze,
};
use feeler_control::{
    AdmittanceGains, ForceGains, ImpedanceGains, Law, LeadSpec, LowPassSpec, PositionGains,
};
use feeler_engine::{Program, RunSettings, Scenario, Simulation, Trace};
use feeler_lti::{C64, LoopTransfer, StateSpace};
use feeler_plant::description::{Body, GROUND, LowPass, Quantity};
use nalgebra::{DMatrix, DVector};

/// Two methods for the same edge, each accurate to about 1e-11.
pub(crate) const SAME_EDGE: f64 = 1e-9;

/// The largest stable gain; NaN if there is none.
pub(crate) fn bands(scenario: &Scenario, key: &str) -> f64 {
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
    // The instant of the first sample does not matter either.
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
        let request = Request {
            gain: Some("controllers.force.damping".into()),
            view: View::CLAMPED,
            ..Request::default()
        };
        let gain = analyze(scenario, &request).unwrap().looped.unwrap().gain;
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
        assert!(
            (largest / expected - 1.0).abs() < SAME_EDGE && (at_hz - edge_hz).abs() <= SAME_EDGE * edge_hz
        );
    }
}

#[test]
fn regress_what_no_ingredient_s_absence_makes_stable_is_not_called_unlimited() {
    let mut scenario = force_loop(0.3, 0.0);
    let Law::ExplicitForce(gains) = &mut scenario.controllers["force"].spec.law else { unreachable!() };
    // Far beyond the integral gain that the axis tolerates at any proportional gain.
    gains.ki = 1e5;
    let request = Request { gain: Some("kp".into()), view: View::CLAMPED, ..Request::default() };
    let report = analyze(&scenario, &request).unwrap();
    assert!(report.gain().unwrap().sampled.all.bands.is_empty());
    let without = &report.waterfall().unwrap().without;
    let stiff = without.iter().find(|(name, _)| name == "springs.transmission").unwrap();
    assert_eq!(stiff.1, Relief::NoneEither);
    assert_eq!(serde_json::to_value(stiff.1).unwrap(), "none");
}

/// Lifted loops of every law, several rates, delays and filters: the matrix predicts the state after a common
/// period as the engine computes it.
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
            Law::Admittance(AdmittanceGains {
                mass: 5.0,
                damping: 300.0,
                stiffness: 1e3,
                kp: 1e4,
                kd: 50.0,
                velocity_feed_forward: 0.0,
            }),
            "force",
        ),
    ];
    for (law, reads) in laws {
        let mut machine = machine();
        machine.sensors["force"].low_pass =
            Some(LowPass::SecondOrder { corner_hz: 150.0, damping_ratio: 0.7 });
        let mut main = control(law, reads, 2e-3, 0.7e-3);
        main.spec.reading_low_pass = Some(LowPassSpec { cutoff_hz: 90.0, damping_ratio: None });
        let damper = control(
            Law::ExplicitForce(ForceGains { damping: 30.0, ..ForceGains::default() }),
            "force",
            3e-3,
            0.0,
        );
        let controllers = [("main".to_string(), main), ("damper".to_string(), damper)].into_iter().collect();
        let periods = 5;
        let run = RunSettings {
            duration_s: f64::from(periods) * 6e-3,
            record: vec!["tip.position".parse().unwrap()],
            ..RunSettings::default()
        };
        let scenario = Scenario { machine, controllers, run };
        let whole = ControlLoop::new(&scenario, &View::CLAMPED).unwrap();
        let lifted = SampledLoop::new(&whole).unwrap();
        assert!((lifted.common_period_s() - 6e-3).abs() < 1e-15);

        let program = Program::new(&scenario).unwrap();
        let states = program.motion().layout().states();
        let mut simulation = Simulation::<f64>::new(vec![program]).unwrap();
        // Only speeds at the start: controllers begin settled at their first readings, which are then zero as
        // in the lifted loop.
        let mut start = vec![0.0; states];
        start[2] = 0.3;
        start[3] = -0.2;
        simulation.set_state(0, &start).unwrap();
        simulation
            .run_to(f64::from(periods) * 6e-3 - 1e-9, &mut Trace::new(&["tip.position".into()]))
            .unwrap();
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
            assert!(
                (got[i] - x[i]).abs() < 1e-9 + 1e-6 * size,
                "{}: coordinate {i}: {} {}",
                reads,
                got[i],
                x[i]
            );
        }
    }
}

#[test]
fn truth_report_of_the_flexible_axis_has_the_contract_s_shape() {
    let report =
        analyze(&force_loop(0.3, 0.0), &Request { view: View::CLAMPED, ..Request::default() }).unwrap();
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
    assert_eq!(report.limit(), Some(Limit::Sampling));
    // The unstable branch starts at the rigid-body motion; the flexible mode takes its phase (the paper's
    // Fig. 8).
    assert_eq!(report.gain().unwrap().continuous.as_ref().unwrap().edge_mode, Some(0));
}

/// A damped mode's phase reaches its final value to 2 zeta f0 / f: at a thousand times the highest mode, 1e-3
/// degrees remain.
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
    // The transmission reverses everything above it. The workpiece's mode is noncolocated too, so zeros lie
    // between both.
    assert_eq!(
        classes,
        [ModeClass::Colocated, ModeClass::Colocated, ModeClass::Noncolocated, ModeClass::Noncolocated]
    );
    let lost: Vec<f64> = report.modes.iter().map(|mode| mode.phase_change_deg).collect();
    assert_eq!(lost.iter().map(|v| v.round() as i32).collect::<Vec<_>>(), [0, -180, -180, 0]);
    let plant = feeler_analysis::LinearMachine::new(&scenario.machine, &View::CLAMPED).unwrap();
    let channel = plant.channel(&report.input.parse().unwrap(), &report.output.parse().unwrap()).unwrap();
    // The transmission's damping is a real zero, with 90 degrees of lead at high frequency.
    assert_eq!(report.zeros.iter().filter(|zero| zero[1].abs() < 1e-9).count(), 1);
    let frequencies: Vec<f64> =
        (0..40_000).map(|i| 0.1 * 10_f64.powf(7.0 * f64::from(i) / 40_000.0)).collect();
    let phase = feeler_lti::unwrapped_phase_rad(&channel.frequency_response(&frequencies).unwrap());
    let turned = (phase[phase.len() - 1] - phase[0]).to_degrees();
    assert!((turned - 90.0 - lost.iter().sum::<f64>()).abs() < PHASE_LEFT_DEG, "{turned}");
}

#[test]
fn truth_an_edge_of_a_whole_machine_which_nothing_holds_is_of_no_mode() {
    // A delayed position loop oscillates as a whole at a few hertz, far below its only mode.
    let mut scenario = force_loop(0.0, 0.0);
    scenario.machine.sensors.insert("end".into(), sensor("tip", Quantity::Position));
    let law = Law::Position(PositionGains {
        kp: 50.0,
        kd: 30.0,
        derivative_filter_s: 2e-3,
        ..PositionGains::default()
    });
    scenario.controllers = [("pos".to_string(), control(law, "end", 1e-3, 20.3e-3))].into_iter().collect();
    let report = analyze(&scenario, &Request { view: View::FREE, ..Request::default() }).unwrap();
    let sampled = &report.gain().unwrap().sampled;
    assert!(report.modes.len() == 1 && report.modes[0].frequency_hz > 20.0 * sampled.edge_hz.unwrap());
    assert_eq!(sampled.edge_mode, None);
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
    assert_eq!(report.limit(), Some(Limit::Saturation), "{:?}", report.waterfall());
}

#[test]
fn truth_sensitivities_of_a_rigid_axis_follow_its_scaling() {
    let whole = ControlLoop::new(&force_loop(0.3, 0.0), &View::CLAMPED).unwrap();
    let all = whole.sensitivities("kp", Workers::default()).unwrap();
    let of = |key: &str| all.iter().find(|s| s.key == key).unwrap();
    // More contact stiffness means more loop gain for the same kp, so the stable range shrinks.
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

/// Feedback of a static contact with reversed sign: at kp = -1 the loop cancels the contact force exactly,
/// with any hold and sampling.
#[test]
fn truth_a_stable_range_goes_on_below_zero_to_where_the_force_drifts() {
    let mut scenario = force_loop(0.3, 0.0);
    let range = |scenario: &Scenario| {
        analyze(scenario, &Request { view: View::CLAMPED, ..Request::default() })
            .unwrap()
            .looped
            .unwrap()
            .gain
    };
    let positive = range(&scenario);
    for range in [positive.continuous.unwrap(), positive.sampled.clone()] {
        let [lower, upper] = range.edges;
        let (lower, upper) = (lower.unwrap(), upper.unwrap());
        assert!((lower.gain + 1.0).abs() < SAME_EDGE && lower.frequency_hz < 1e-3, "{lower:?}");
        assert!((upper.gain - range.stable[1].unwrap()).abs() < SAME_EDGE && upper.frequency_hz > 10.0);
        assert_eq!((range.stable[0], range.intervals.len()), (Some(0.0), 1));
    }
    // For a gain below zero, the report gives the interval that contains it.
    let Law::ExplicitForce(gains) = &mut scenario.controllers["force"].spec.law else { unreachable!() };
    gains.kp = -0.5;
    let negative = range(&scenario).sampled;
    assert!(
        (negative.stable[0].unwrap() + 1.0).abs() < SAME_EDGE && negative.edges == positive.sampled.edges
    );
}

#[test]
fn truth_matrices_and_factors_of_a_report_are_one_response() {
    let mut scenario = force_loop(0.3, 0.0);
    scenario.machine.sensors["force"].low_pass = Some(LowPass::FirstOrder { corner_hz: 80.0 });
    let request =
        Request { view: View::CLAMPED, output: Some("force.reading".parse().unwrap()), ..Request::default() };
    let report = analyze(&scenario, &request).unwrap();
    let space = &report.state_space;
    let names = ["motor.position", "tip.position", "motor.velocity", "tip.velocity", "force.filter1"];
    assert_eq!(
        (space.states.as_slice(), space.inputs[0].as_str()),
        (names.map(String::from).as_slice(), "drive.command")
    );
    let matrix = |rows: &[Vec<f64>]| DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
    let system =
        StateSpace::new(matrix(&space.a), matrix(&space.b), matrix(&space.c), matrix(&space.d)).unwrap();
    let s = C64::new(0.0, 150.0);
    let product = |roots: &[[f64; 2]]| roots.iter().map(|[re, im]| s - C64::new(*re, *im)).product::<C64>();
    let factored = product(&report.zeros) / product(&report.poles) * report.zero_pole_gain.unwrap();
    let value = system.at(s).unwrap()[(0, 0)];
    assert!((factored - value).norm() < SAME_EDGE * value.norm(), "{factored} {value}");
    let margins = report.margins().unwrap();
    assert_eq!(
        margins.encirclements,
        margins.unstable_poles.cast_signed() - margins.open_unstable_poles.cast_signed()
    );
}

/// Central differences with steps of 1e-3 and 2e-3, on a curve that changes by its own size over a few per
/// cent.
const DIFFERENCES: f64 = 0.05;

/// A mode of 105 Hz under fast sampling: the response falls 3 dB on the far flank of its peak.
#[test]
fn truth_advice_is_by_the_largest_gain_where_the_bandwidth_rides_a_mode() {
    let mut scenario = force_loop(0.3, 0.0);
    let asked = |scenario: &Scenario| {
        analyze(scenario, &Request { view: View::CLAMPED, sensitivities: true, ..Request::default() })
            .unwrap()
    };
    let slow = asked(&scenario);
    assert_eq!(
        (slow.waterfall().unwrap().rides_mode, slow.ranked_by()),
        (None, Some(RankedBy::BandwidthAndGain))
    );
    // Parameters that raise both are worth most; the contact's stiffness trades gain for bandwidth.
    assert!(
        !slow.sensitivities()[0].trades
            && slow.sensitivities().last().unwrap().key == "contacts.tool.stiffness"
    );
    scenario.controllers["force"].spec.period_s = 1e-4;
    let fast = asked(&scenario);
    assert_eq!(
        (fast.waterfall().unwrap().rides_mode, fast.ranked_by()),
        (Some(1), Some(RankedBy::LargestGain))
    );
    let gains: Vec<f64> = fast.sensitivities().iter().map(|s| s.largest_gain_relative.abs()).collect();
    assert!(gains.is_sorted_by(|a, b| a >= b), "{gains:?}");
}

/// At rest the drive must give kp / (1 + kp) of the reference, less below the resonance and more above it.
#[test]
fn truth_a_saturating_loop_is_told_what_saturation_answers_to() {
    let mut scenario = force_loop(0.6, 0.0);
    scenario.machine.actuators["drive"].limit_n = Some(8.8);
    scenario.controllers["force"].spec.reference = feeler_control::ReferenceSpec::Constant(20.0);
    let asked = |scenario: &Scenario| {
        analyze(scenario, &Request { view: View::CLAMPED, sensitivities: true, ..Request::default() })
            .unwrap()
    };
    let report = asked(&scenario);
    assert_eq!((report.limit(), report.ranked_by()), (Some(Limit::Saturation), Some(RankedBy::Saturation)));
    let limit = report.sensitivities().iter().find(|s| s.key == "actuators.drive.limit").unwrap();
    assert!(limit.bandwidth_relative > 0.0);
    // Central differences with twice the step, to check that a quantity located by bisection has a
    // derivative.
    let at = |limit: f64| {
        scenario.machine.actuators["drive"].limit_n = Some(limit);
        asked(&scenario).looped.unwrap().waterfall.unwrap().saturation_hz.unwrap()
    };
    let (mut at, step) = (at, 2e-3);
    let slope = (at(8.8 * (1.0 + step)) / at(8.8 * (1.0 - step))).ln() / ((1.0 + step) / (1.0 - step)).ln();
    assert!((slope / limit.bandwidth_relative - 1.0).abs() < DIFFERENCES, "{slope} {limit:?}");
    // Below the demand at rest: the drive saturates at rest.
    assert!(at(5.0).abs() < SAME_EDGE);
}

#[test]
fn regress_another_output_changes_neither_the_loop_nor_what_limits_it() {
    let scenario = force_loop(0.3, 0.0);
    let asked = |output: Option<&str>| {
        let output = output.map(|name| name.parse().unwrap());
        analyze(
            &scenario,
            &Request { view: View::CLAMPED, sensitivities: true, output, ..Request::default() },
        )
        .unwrap()
    };
    let (own, other) = (asked(None), asked(Some("motor.position")));
    // Seen from the motor every mode is colocated; in the force loop the transmission's is not.
    let classes = |report: &feeler_analysis::Report| {
        report.modes.iter().map(|mode| (mode.class, mode.class_in_loop)).collect::<Vec<_>>()
    };
    assert_eq!(classes(&other)[1], (ModeClass::Colocated, Some(ModeClass::Noncolocated)));
    assert_eq!(classes(&own)[1], (ModeClass::Noncolocated, Some(ModeClass::Noncolocated)));
    let costs = |report: &feeler_analysis::Report| {
        report.modes.iter().map(|mode| mode.margin_cost_deg).collect::<Vec<_>>()
    };
    assert_eq!(costs(&own), costs(&other));
    assert_eq!((own.waterfall(), own.gain(), own.pair()), (other.waterfall(), other.gain(), other.pair()));
    let of = other.pair().unwrap();
    assert_eq!((of.controller.as_str(), of.output.as_str()), ("force", "tool.spring_force"));
    assert!(other.zeros_hz != own.zeros_hz);
}
