//! The limit of a bandwidth, and the report if there is no waterfall.

use std::f64::consts::TAU;

use crate::common::{control, force_loop, machine, spring};
use feeler_analysis::{Limit, LinearMachine, Report, Request, View, WhyNoWaterfall, analyze};
use feeler_control::{ControllerSpec, ForceGains, ImpedanceGains, Law};
use feeler_engine::{ControllerUse, Scenario};
use feeler_plant::assembly::assemble;
use feeler_plant::description::{ContactLaw, GROUND, LowPass, Machine};

fn clamped(scenario: &Scenario, gain: Option<&str>) -> Report {
    let request = Request {
        view: View::CLAMPED,
        gain: gain.map(Into::into),
        sensitivities: true,
        ..Request::default()
    };
    analyze(scenario, &request).unwrap_or_else(|error| panic!("{error}"))
}

/// Integral action a decade below the plateau of the response, and the first mode a decade above it, change
/// the plateau by some per cent.
const SHELF: f64 = 0.05;

#[test]
fn regress_a_bandwidth_that_jumps_is_told_to_be_that_of_the_integrator() {
    let mut scenario = force_loop(0.2, 0.7e-3);
    scenario.machine.springs["guide"].damping_n_s_per_m = 900.0;
    let spec = &mut scenario.controllers["force"].spec;
    spec.law = Law::ExplicitForce(ForceGains { kp: 0.2, ki: 3.0, ..ForceGains::default() });
    spec.period_s = 2e-3;
    let stages = clamped(&scenario, Some("kp")).looped.unwrap().waterfall.unwrap().stages;
    let last = stages.last().unwrap();
    // With half of the gain, kp / (1 + kp) of the reference is more than 3 dB down: the integrator alone
    // carries the rest.
    let kp = 0.5 * last.largest_gain.unwrap();
    assert!(kp / (1.0 + kp) < 0.70 && last.bandwidth_hz.unwrap() < 3.0, "{last:?}");
    let shelf = last.shelf.unwrap();
    assert!((shelf.share / (kp / (1.0 + kp)) - 1.0).abs() < SHELF && shelf.to_hz > 20.0, "{shelf:?}");
    // Every step down is the product of the ingredient and of the gain that it allows.
    let first = stages.iter().position(|stage| stage.largest_gain.is_some()).unwrap();
    assert!(stages[first].bandwidth_at_gain_before_hz.is_none());
    for pair in stages[first..]
        .windows(2)
        .filter(|pair| 0.5 * pair[0].largest_gain.unwrap() < pair[1].largest_gain.unwrap())
    {
        assert!(pair[1].bandwidth_at_gain_before_hz.is_some(), "{pair:?}");
    }
    // A loop without filters has no row for them, nor for a delay of zero.
    for (delay_s, end) in [(0.0, "hold"), (0.7e-3, "delay")] {
        let stages = clamped(&force_loop(0.5, delay_s), None).looped.unwrap().waterfall.unwrap().stages;
        let last = stages.last().unwrap();
        assert_eq!(last.added, end);
        assert!(last.shelf.is_none());
    }
}

#[test]
fn regress_an_undamped_axis_is_unstable_at_any_gain_and_says_so() {
    let mut scenario = force_loop(0.5, 0.0);
    scenario.machine.springs["transmission"].rigid = true;
    scenario.machine.springs["guide"].damping_n_s_per_m = 0.0;
    scenario.machine.contacts["tool"].damping_n_s_per_m = 0.0;
    let report = clamped(&scenario, None);
    // Closed form E: a held output destabilises the undamped axis at any sample rate.
    assert_eq!(report.limit(), Some(Limit::UndampedMode));
    let expected_hz = (2e5_f64 / 12.0).sqrt() / TAU;
    assert!(
        matches!(report.undamped_hz.as_slice(), [f] if (f / expected_hz - 1.0).abs() < 1e-12),
        "{:?}",
        report.undamped_hz
    );
    assert_eq!(report.margins().unwrap().gain_decrease, None);
    assert!(report.sensitivities().is_empty() && report.ranked_by().is_none());
    assert!(clamped(&force_loop(0.5, 0.0), None).undamped_hz.is_empty());
}

#[test]
fn regress_a_response_that_only_falls_has_no_peak_above_rest() {
    let mut scenario = force_loop(0.0, 0.0);
    scenario.controllers["force"].spec.law =
        Law::ExplicitForce(ForceGains { ki: 3.0, ..ForceGains::default() });
    let falls = clamped(&scenario, None).looped.unwrap().margins.unwrap();
    assert!(
        falls.complementary_sensitivity_peak_hz <= 0.0
            && (falls.complementary_sensitivity_peak - 1.0).abs() < 1e-6,
        "{falls:?}"
    );
    let rings = clamped(&force_loop(0.5, 0.0), None).looped.unwrap().margins.unwrap();
    assert!(rings.complementary_sensitivity_peak_hz > 15.0, "{rings:?}");
}

#[test]
fn regress_an_absent_contact_is_no_number_of_the_machine() {
    let mut scenario = force_loop(0.0, 0.0);
    let law = Law::Position(feeler_control::PositionGains { kp: 2e4, damping: 200.0, ..Default::default() });
    scenario.controllers = [("axis".to_string(), control(law, "encoder", 1e-3, 0.0))].into_iter().collect();
    let request = Request { view: View::FREE, sensitivities: true, ..Request::default() };
    let free = analyze(&scenario, &request).unwrap().looped.unwrap().sensitivities;
    assert!(!free.is_empty() && free.iter().all(|s| !s.key.starts_with("contacts.")), "{free:?}");
    assert!(clamped(&scenario, None).sensitivities().iter().any(|s| s.key == "contacts.tool.stiffness"));
}

#[test]
fn regress_a_slower_controller_is_named_as_why_nothing_is_told() {
    let mut scenario = force_loop(0.2, 0.0);
    let damper =
        control(Law::ExplicitForce(ForceGains { kp: 0.1, ..ForceGains::default() }), "force", 0.25e-3, 0.0);
    scenario.controllers.insert("fast".into(), damper);
    let report = clamped(&scenario, Some("fast.kp"));
    let Some(WhyNoWaterfall::SlowerLoop { controller, period_s, common_s, slowest }) =
        report.why_no_waterfall()
    else {
        panic!("{:?}", report.why_no_waterfall())
    };
    assert_eq!((controller.as_str(), slowest.as_deref()), ("fast", Some("force")));
    assert!((period_s - 0.25e-3).abs() < 1e-12 && (common_s - 1e-3).abs() < 1e-12);
    assert!(report.waterfall().is_none() && report.gain().unwrap().sampled.stable[1].is_some());
    assert_eq!(clamped(&scenario, Some("force.kp")).why_no_waterfall(), None);
}

#[test]
fn regress_where_no_period_is_a_multiple_of_the_others_no_controller_tells_all() {
    let mut scenario = force_loop(0.2, 0.0);
    let other =
        control(Law::ExplicitForce(ForceGains { kp: 0.1, ..ForceGains::default() }), "force", 1.5e-3, 0.0);
    scenario.controllers.insert("other".into(), other);
    for gain in ["force.kp", "other.kp"] {
        let report = clamped(&scenario, Some(gain));
        let untold = report.why_no_waterfall();
        assert!(
            matches!(untold, Some(WhyNoWaterfall::SlowerLoop { slowest: None, .. })),
            "{gain}: {untold:?}"
        );
    }
}

#[test]
fn truth_nothing_limits_a_loop_whose_reading_does_not_answer_the_drive() {
    let request = Request { view: View::FREE, ..Request::default() };
    let report = analyze(&force_loop(0.2, 0.0), &request).unwrap();
    assert_eq!(report.limit(), Some(Limit::Nothing));
}

/// An axis under impedance control that may feel its force as well.
fn impedance(force_gain: f64) -> Scenario {
    let law = Law::Impedance(ImpedanceGains { stiffness: 5e3, damping: 350.0, force_gain });
    let spec = ControllerSpec::new(law, 1e-3);
    let user = ControllerUse {
        spec,
        reads: Some("force".into()),
        motion: Some("encoder".into()),
        drives: "drive".into(),
        effects: Vec::new(),
    };
    Scenario {
        machine: machine(),
        controllers: [("spring".to_string(), user)].into_iter().collect(),
        ..force_loop(0.0, 0.0)
    }
}

#[test]
fn regress_an_impedance_controls_motion_and_its_force_gain_closes_a_loop_of_force() {
    for (force_gain, key, through) in [
        (0.0, "stiffness", "motor.position"),
        (0.0, "force_gain", "tool.spring_force"),
        (0.3, "stiffness", "tool.spring_force"),
        (0.3, "force_gain", "tool.spring_force"),
    ] {
        let report = clamped(&impedance(force_gain), Some(key));
        let of = report.pair().unwrap();
        assert_eq!(
            (of.output.as_str(), of.controlled.as_str()),
            (through, "motor.position"),
            "{force_gain} {key}"
        );
        assert_eq!(report.output, through);
        assert!(report.gain().unwrap().sampled.stable[1].is_some(), "{force_gain} {key}");
    }
}

#[test]
fn truth_a_force_on_a_body_is_an_input() {
    // An ideal drive between the ground and a body has the same effect as an outer force on that body.
    let scenario = force_loop(0.2, 0.0);
    let of = |input: &str| {
        analyze(
            &scenario,
            &Request { input: Some(input.parse().unwrap()), view: View::CLAMPED, ..Request::default() },
        )
    };
    let (drive, outer) = (of("drive.command").unwrap(), of("motor.force").unwrap());
    assert_eq!(outer.input, "motor.force");
    assert_eq!((&drive.poles, &drive.zeros, drive.gain()), (&outer.poles, &outer.zeros, outer.gain()));
    // A force on another body gives the same poles and other zeros.
    let tip = of("tip.force").unwrap();
    assert_eq!(drive.poles.len(), tip.poles.len());
    assert_ne!(drive.zeros.len(), tip.zeros.len());
    assert!(of("motor.position").is_err());
}

#[test]
fn truth_no_eigenvalue_is_beyond_the_bound_on_rates() {
    let mut machine = machine();
    machine.sensors["force"].low_pass = Some(LowPass::SecondOrder { corner_hz: 40.0, damping_ratio: 0.7 });
    let largest = |machine: &Machine| {
        let plant = LinearMachine::new(machine, &View::CLAMPED).unwrap();
        let channel =
            plant.channel(&"drive.command".parse().unwrap(), &"force.reading".parse().unwrap()).unwrap();
        let rates: Vec<f64> = channel.poles().unwrap().iter().map(|p| p.norm()).collect();
        rates.into_iter().fold(0.0, f64::max)
    };
    let bound = |machine: &Machine| assemble(machine).unwrap().fastest_rate_per_s();
    // Gershgorin's bound exceeds the largest rate of a chain by less than a factor of two.
    assert!(
        (largest(&machine)..2.0 * largest(&machine)).contains(&bound(&machine)),
        "{} {}",
        largest(&machine),
        bound(&machine)
    );
    // A filter, and a guide, faster than everything else.
    machine.sensors["force"].low_pass = Some(LowPass::FirstOrder { corner_hz: 1e4 });
    assert!((bound(&machine) / (TAU * 1e4) - 1.0).abs() < 1e-12);
    machine.springs["guide"].damping_n_s_per_m = 1e7;
    assert!(
        (largest(&machine)..2.5 * largest(&machine)).contains(&bound(&machine)),
        "{} {}",
        largest(&machine),
        bound(&machine)
    );
    machine.contacts["tool"].law = ContactLaw::Hertz;
    assert!(bound(&machine).is_infinite());
}

#[test]
fn regress_a_driven_body_on_a_spring_to_ground_keeps_its_account() {
    let mut scenario = force_loop(0.05, 0.0);
    let guide = &mut scenario.machine.springs["guide"];
    guide.stiffness_n_per_m = 1e5;
    let report = clamped(&scenario, None);
    let stages: Vec<&str> =
        report.waterfall().unwrap().stages.iter().map(|stage| stage.added.as_str()).collect();
    // The transmission can be made rigid. The spring that holds the motor cannot: nothing could move.
    assert!(stages.contains(&"springs.transmission") && !stages.contains(&"springs.guide"), "{stages:?}");
    assert!(report.waterfall().unwrap().without.iter().all(|(name, _)| name != "springs.guide"));
}

#[test]
fn truth_what_is_set_beyond_the_edge_is_told_without_margins() {
    let mut scenario = force_loop(0.2, 0.0);
    let fast =
        control(Law::ExplicitForce(ForceGains { kp: 0.1, ..ForceGains::default() }), "force", 0.25e-3, 0.0);
    scenario.controllers.insert("fast".into(), fast);
    let edge = clamped(&scenario, Some("fast.kp")).looped.unwrap().gain.sampled.stable[1].unwrap();
    for (kp, unstable) in [(0.99 * edge, false), (1.01 * edge, true)] {
        scenario.controllers["fast"].spec.law =
            Law::ExplicitForce(ForceGains { kp, ..ForceGains::default() });
        assert_eq!(
            clamped(&scenario, Some("fast.kp")).looped.unwrap().gain.is_unstable_as_set(),
            unstable,
            "{kp}"
        );
    }
}

#[test]
fn truth_a_spring_that_rounding_loses_is_an_assumption() {
    // Both bodies rest on springs of 1e12 N/m; the last digit of such a double is 1e-4 N/m.
    let lost = |stiffness: f64| {
        let mut scenario = force_loop(0.2, 0.0);
        let springs = &mut scenario.machine.springs;
        springs.insert("post".into(), spring(GROUND, "motor", 1e12, 0.0));
        springs.insert("wall".into(), spring(GROUND, "tip", 1e12, 0.0));
        springs.insert("transmission".into(), spring("motor", "tip", stiffness, 0.0));
        let report = analyze(&scenario, &Request { view: View::CLAMPED, ..Request::default() }).unwrap();
        let found = report.assumptions.iter().filter(|assumption| assumption.property == "stiffness");
        found.map(|assumption| assumption.of.clone()).collect::<Vec<_>>()
    };
    assert_eq!(lost(1e-6), ["springs.transmission"]);
    assert_eq!(lost(0.1), Vec::<String>::new());
}
