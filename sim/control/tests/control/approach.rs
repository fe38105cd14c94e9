//! Approach, then switch, with hysteresis.

use std::f64::consts::TAU;

use feeler_control::{
    Approach, ControlError, Controller, ControllerSpec, ForceGains, Inputs, Law, PositionGains,
};
use feeler_lanes::{LaneMask, Pack};

const PERIOD_S: f64 = 1e-3;
const ROUNDING: f64 = 1e-11;

fn spec(approach: Approach) -> ControllerSpec {
    let gains = ForceGains { kp: 2.0, ki: 10.0, kd: 0.5, ..ForceGains::default() };
    ControllerSpec { approach: Some(approach), ..ControllerSpec::new(Law::ExplicitForce(gains), PERIOD_S) }
}

fn at(reading: f64, position: f64) -> Inputs<f64> {
    Inputs { reading, motion: position, motion_is_velocity: false }
}

#[test]
fn truth_force_drive_follows_a_ramp_from_where_it_stands() {
    let approach = Approach { bandwidth_hz: 5.0, ..Approach::new(0.03, 4.0, 12.0) };
    let mut controller = Controller::<f64>::new(&[spec(approach)]).unwrap();
    let w = TAU * 5.0;
    let (start_s, x0) = (0.2, 0.5);
    for k in 0..30 {
        let t = f64::from(k) * PERIOD_S;
        // The axis lags: it moves at 0.01 m/s.
        let (x, v) = (x0 + 0.01 * t, if k == 0 { 0.0 } else { 0.01 });
        let expected = 12.0 * w * w * (x0 + 0.03 * t - x) + 2.0 * 0.7 * 12.0 * w * (0.03 - v);
        let u = controller.sample(start_s + t, &at(0.0, x), 20.0);
        assert!((u - expected).abs() < ROUNDING * 1e3, "{u} is not {expected}");
        assert!(!controller.in_contact_phase());
    }
}

#[test]
fn truth_velocity_source_is_commanded_the_speed() {
    let approach = Approach { velocity_drive: true, ..Approach::new(0.03, 4.0, 0.0) };
    let mut controller = Controller::<f64>::new(&[spec(approach)]).unwrap();
    for k in 0..3 {
        let u = controller.sample(f64::from(k) * PERIOD_S, &at(1.0, 0.3 * f64::from(k)), 20.0);
        assert!((u - 0.03).abs() < ROUNDING);
    }
}

#[test]
fn truth_the_law_starts_fresh_at_the_threshold_and_latches() {
    let mut controller = Controller::<f64>::new(&[spec(Approach::new(0.03, 4.0, 12.0))]).unwrap();
    for k in 0..100 {
        controller.sample(f64::from(k) * PERIOD_S, &at(3.999, 0.0), 20.0);
        assert!(!controller.in_contact_phase());
    }
    // Proportional part and one sample of integral: the approach leaves no integral, and there is no
    // derivative kick.
    let u = controller.sample(0.1, &at(4.0, 0.0), 20.0);
    assert!((u - (2.0 * 16.0 + 10.0 * PERIOD_S * 16.0)).abs() < ROUNDING);
    controller.sample(0.101, &at(0.0, 0.0), 20.0);
    assert!(controller.in_contact_phase(), "without a release threshold contact lasts");
}

#[test]
fn truth_hysteresis_between_release_and_until() {
    let approach = Approach { release: Some(1.0), ..Approach::new(0.03, 4.0, 12.0) };
    let mut controller = Controller::<f64>::new(&[spec(approach)]).unwrap();
    let readings = [0.0, 3.0, 4.0, 2.0, 1.0, 0.9, 1.0, 3.9, 4.1, 0.0];
    let in_contact = [false, false, true, true, true, false, false, false, true, false];
    for (k, (reading, expected)) in readings.into_iter().zip(in_contact).enumerate() {
        controller.sample(k as f64 * PERIOD_S, &at(reading, 0.0), 20.0);
        assert_eq!(controller.in_contact_phase(), expected, "sample {k}");
    }
    // The second approach begins at the present position, without catching up.
    controller.reset();
    controller.sample(0.0, &at(5.0, 0.0), 20.0);
    let u = controller.sample(9.0, &at(0.0, 0.0), 20.0);
    let w = TAU * Approach::DEFAULT_BANDWIDTH_HZ;
    assert!((u - 2.0 * 0.7 * 12.0 * w * 0.03).abs() < ROUNDING);
    // When contact returns the law starts again without history.
    let u = controller.sample(9.001, &at(5.0, 0.0), 20.0);
    assert!((u - 15.0 * (2.0 + 10.0 * PERIOD_S)).abs() < ROUNDING);
}

#[test]
fn prop_lanes_switch_each_at_its_own_threshold() {
    let with_threshold = |until| spec(Approach::new(0.03, until, 12.0));
    let none = ControllerSpec { approach: None, ..with_threshold(1.0) };
    let specs = [with_threshold(1.0), with_threshold(3.0), none, with_threshold(-1.0)];
    let mut controller = Controller::<Pack<4>>::new(&specs).unwrap();
    controller.sample(0.0, &Inputs { reading: Pack([2.0; 4]), ..Inputs::default() }, Pack([20.0; 4]));
    assert_eq!([0, 1, 2, 3].map(|i| controller.in_contact_phase().test(i)), [true, false, true, true]);
}

#[test]
fn prop_an_approach_that_cannot_work_is_refused() {
    let approach = Approach { release: Some(5.0), ..Approach::new(0.03, 4.0, 12.0) };
    let refused = Controller::<f64>::new(&[spec(approach)]).unwrap_err();
    assert!(matches!(&refused, ControlError::TooLarge { key, .. } if key == "approach.release"), "{refused}");
    let massless = Controller::<f64>::new(&[spec(Approach::new(0.03, 4.0, 0.0))]).unwrap_err();
    assert_eq!(massless, ControlError::ApproachMass { value: 0.0 });
    let position = ControllerSpec {
        law: Law::Position(PositionGains::default()),
        ..spec(Approach::new(0.03, 4.0, 12.0))
    };
    assert_eq!(Controller::<f64>::new(&[position]).unwrap_err(), ControlError::ApproachNeedsForce);
}
