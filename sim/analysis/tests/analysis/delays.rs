//! Loops of many samples of delay.

use feeler_analysis::{AnalysisError, ControlLoop, Request, SampledLoop, View, analyze};
use feeler_control::Law;
use feeler_plant::effects::{EffectUse, find};

use crate::common::force_loop;
use crate::loops::{SAME_EDGE, bands};

/// A bisected frequency is accurate to 1e-16 relative. The gain there is accurate to that times its phase
/// rate: about 1e3 for fifty samples of delay.
const LATE_EDGE: f64 = 1e-9;

/// Eigenvalues of the lifted loop and the real gains of the frequency response are two methods for the same
/// edges. Thirty samples of delay use the second.
#[test]
fn truth_edges_of_a_late_loop_are_those_of_the_lifted_one() {
    let late = force_loop(0.02, 30.4e-3);
    let whole = ControlLoop::new(&late, &View::CLAMPED).unwrap();
    let edge = whole.sampled_bands("kp").unwrap().bands[0].upper.clone().unwrap();
    let lifted = SampledLoop::new(&whole).unwrap();
    let growth = |gain: f64| {
        let values = feeler_lti::eigenvalues(&lifted.closed_loop_with(0, "kp", gain).unwrap()).unwrap();
        values.iter().map(|z| z.norm()).fold(0.0, f64::max) - 1.0
    };
    assert!(growth(edge.gain * (1.0 - 1e-6)) < 0.0 && growth(edge.gain * (1.0 + 1e-6)) > 0.0, "{edge:?}");
    assert_eq!(edge.mode, Some(0));
    let margins = whole.open_loop(0).unwrap().transfer().unwrap().margins().unwrap();
    let increase = margins.smallest_increase().unwrap();
    assert!(
        (increase.factor * 0.02 / edge.gain - 1.0).abs() < LATE_EDGE
            && (increase.frequency_hz - edge.frequency_hz).abs() < 1e-6
    );
    // For a loop that is unstable several times over, the gain must fall to this edge.
    let unstable = analyze(&force_loop(3.0, 30.4e-3), &Request { view: View::CLAMPED, ..Request::default() })
        .unwrap()
        .looped
        .unwrap()
        .margins
        .unwrap();
    assert!(
        unstable.unstable_poles > 2
            && (unstable.gain_decrease.unwrap() * 3.0 / edge.gain - 1.0).abs() < LATE_EDGE,
        "{unstable:?}"
    );
    // The place of the delay in the loop makes no difference.
    for [command_s, drive_s, sensor_s] in [[0.4e-3, 30e-3, 0.0], [5e-3, 5.4e-3, 20e-3], [0.0, 0.0, 30.4e-3]] {
        let mut other = force_loop(0.02, command_s);
        let definition = find("command-delay").unwrap();
        other.machine.actuators["drive"].effects.push(EffectUse { definition, values: vec![drive_s] });
        other.machine.sensors["force"].delay_s = sensor_s;
        assert!(
            (bands(&other, "kp") / edge.gain - 1.0).abs() < LATE_EDGE,
            "{command_s} {drive_s} {sensor_s}"
        );
    }
}

/// An integral loop with half a second of delay, 500 samples. Nearly all of its phase comes from the delay,
/// so K tau k = pi / 2 except for the hold.
#[test]
fn truth_five_hundred_samples_of_delay_are_analysed_whole() {
    let mut scenario = force_loop(0.0, 0.5);
    let Law::ExplicitForce(gains) = &mut scenario.controllers["force"].spec.law else { unreachable!() };
    gains.ki = 1.0;
    let request = Request { view: View::CLAMPED, gain: Some("ki".into()), ..Request::default() };
    scenario.machine.springs["guide"].damping_n_s_per_m = 2000.0;
    let report = analyze(&scenario, &request).unwrap();
    let gain = report.gain().unwrap();
    let expected = std::f64::consts::FRAC_PI_2 / 0.5;
    // Lags of hold, the integrator's sample and the damped contact: 12 ms of 500 in total.
    assert!((gain.sampled.stable[1].unwrap() / expected - 1.0).abs() < 0.03, "{:?}", gain.sampled.edges);
    assert!(gain.sampled.edges[0].as_ref().unwrap().gain.abs() < SAME_EDGE);
    assert!(
        report.margins().unwrap().delay_s.is_some()
            && report.waterfall().unwrap().stages.iter().any(|stage| stage.added == "delay")
    );
}

#[test]
fn regress_a_delay_that_is_no_factor_of_the_loop_is_refused_when_it_is_too_long() {
    let mut scenario = force_loop(0.1, 0.0);
    let Law::ExplicitForce(gains) = &mut scenario.controllers["force"].spec.law else { unreachable!() };
    gains.damping = 10.0;
    scenario.machine.sensors["force"].delay_s = 0.5;
    let refused = analyze(&scenario, &Request { view: View::CLAMPED, ..Request::default() });
    assert!(matches!(refused, Err(AnalysisError::LongDelay { stored: 500, .. })), "{refused:?}");
}
