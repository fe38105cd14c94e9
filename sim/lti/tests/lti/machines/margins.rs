//! Margins against closed forms and against the eigenvalues of the closed loop.

use std::f64::consts::{FRAC_PI_2, TAU};

use feeler_lti::{AffineLoop, LoopTransfer, StateSpace};
use nalgebra::dmatrix;

use super::paper_models::ROWS;

/// Crossings are bisected to machine precision; the remaining error is that of the response.
const CROSSING: f64 = 1e-10;

fn integrator(gain: f64) -> StateSpace {
    StateSpace::new(dmatrix![0.0], dmatrix![gain], dmatrix![1.0], dmatrix![0.0]).unwrap()
}

#[test]
fn truth_third_order_loop() {
    // 2 / (s + 1)^3: phase crossover at sqrt(3), |L| there 2/8; unit gain at sqrt(2^(2/3) - 1).
    let lag = StateSpace::new(dmatrix![-1.0], dmatrix![1.0], dmatrix![1.0], dmatrix![0.0]).unwrap();
    let plant = lag.series(&lag).unwrap().series(&lag).unwrap().scaled(2.0);
    let margins = LoopTransfer::continuous(&plant, 0.0).unwrap().margins().unwrap();
    let gain = margins.smallest_increase().unwrap();
    assert!(
        (gain.factor - 4.0).abs() < CROSSING && (gain.frequency_hz * TAU - 3.0_f64.sqrt()).abs() < CROSSING
    );
    let w = (2.0_f64.powf(2.0 / 3.0) - 1.0).sqrt();
    let phase = margins.smallest_phase().unwrap();
    assert!((phase.frequency_hz * TAU - w).abs() < CROSSING);
    let truth = std::f64::consts::PI - 3.0 * w.atan();
    assert!((phase.margin_rad - truth).abs() < CROSSING && (phase.delay_s - truth / w).abs() < CROSSING);
    assert!(margins.closed_loop_stable && margins.smallest_decrease().is_none());
    // The disk margin is never larger than either classical margin.
    let alpha = margins.disk.alpha;
    assert!((2.0 + alpha) / (2.0 - alpha) < gain.factor && 2.0 * (0.5 * alpha).atan() < truth);
    // Brute force over a dense grid; a maximum missed by one grid step of 1e-4 is flat to 1e-8.
    let brute = (1..40_000).map(|i| {
        let l = plant.at(feeler_lti::C64::new(0.0, f64::from(i) * 1e-4)).unwrap()[(0, 0)];
        (1.0 / (1.0 + l)).norm()
    });
    assert!((margins.sensitivity.value - brute.fold(0.0, f64::max)).abs() < 1e-7);
}

/// Form D for a continuous delay: G k tau < pi / 2.
#[test]
fn truth_d_integrator_with_continuous_delay() {
    for delay_s in [1e-4, 0.37e-3, 2.0] {
        let intervals = LoopTransfer::continuous(&integrator(1.0), delay_s)
            .unwrap()
            .stable_gains_up_to(30.0 / delay_s)
            .unwrap();
        assert_eq!(intervals.len(), 1, "{intervals:?}");
        assert!(intervals[0].lower.abs() < CROSSING);
        assert!((intervals[0].upper * delay_s / FRAC_PI_2 - 1.0).abs() < CROSSING);
        assert!((intervals[0].upper_frequency_hz * 4.0 * delay_s - 1.0).abs() < CROSSING);
    }
}

#[test]
fn truth_unstable_plant_has_a_lower_margin() {
    // 3 / (s - 1): stable for gains above 1/3 of this; DC value -3.
    let plant = StateSpace::new(dmatrix![1.0], dmatrix![3.0], dmatrix![1.0], dmatrix![0.0]).unwrap();
    let transfer = LoopTransfer::continuous(&plant, 0.0).unwrap();
    let margins = transfer.margins().unwrap();
    assert!(margins.closed_loop_stable);
    assert!((margins.smallest_decrease().unwrap().factor - 1.0 / 3.0).abs() < CROSSING);
    assert_eq!(transfer.closed_loop_unstable_poles(0.2).unwrap(), 1);
}

/// The response and the eigenvalues are two methods for the same edges: for each machine, continuous and
/// sampled.
#[test]
fn truth_nyquist_agrees_with_eigenvalues() {
    for row in &ROWS {
        let plant = row.system();
        let sampled = plant.zero_order_hold_delayed(1e-3, 1.37e-3).unwrap();
        let by_poles = AffineLoop::negative_feedback(&sampled).unwrap().stable_gains().unwrap();
        let scale = by_poles.intervals[0].upper.as_ref().unwrap().gain;
        let transfer = LoopTransfer::discrete(&sampled).unwrap();
        let by_response = transfer.stable_gains_up_to(100.0 * scale).unwrap();
        assert_eq!(by_poles.intervals.len(), by_response.len(), "{}", row.name);
        assert!(
            (by_response[0].upper / scale - 1.0).abs() < 1e-8,
            "{}: {} {scale}",
            row.name,
            by_response[0].upper
        );
        let transfer = LoopTransfer::continuous(&plant, 0.0).unwrap();
        for gain in [0.3, 3.0, 8.0, 20.0, 60.0] {
            let gain = gain * if plant.states() == 3 { 1e-3 } else { 1.0 };
            let closed = AffineLoop::negative_feedback(&plant).unwrap().at(gain);
            let unstable = feeler_lti::eigenvalues(&closed).unwrap().iter().filter(|p| p.re > 0.0).count();
            assert_eq!(
                transfer.closed_loop_unstable_poles(gain).unwrap(),
                unstable,
                "{} at {gain}",
                row.name
            );
        }
    }
}
