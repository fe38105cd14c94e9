//! Closed forms of force control, checked against their printed numbers.

use std::f64::consts::{PI, TAU};

use feeler_lti::{AffineLoop, Continuous, GainSearch, StateSpace, stable_gains};
use nalgebra::{DMatrix, dmatrix};

use super::axis::{Axis, Drive};

/// Edges are bisected to 1e-14; the deciding eigenvalues are accurate to some hundred roundings of the
/// fastest.
const EDGE: f64 = 1e-9;

fn rigid(mass: f64, damping: f64, stiffness: f64, drive: Drive) -> Axis {
    Axis {
        masses: (mass, 0.0),
        guide_damping: damping,
        contact: (stiffness, 0.0),
        transmission: None,
        base: None,
        workpiece: None,
        drive,
        total_force: false,
    }
}

/// Form A: a rigid axis whose force lags with tau; `K_max = b/(tau k) + tau b/m + b^2/(m k)`, at
/// `omega^2 = (b + tau k)/(tau m)`. A velocity source adds its damping `b_m` to b.
#[test]
fn truth_a_rigid_axis_with_force_lag() {
    let (m, b, k) = (20.0_f64, 200.0, 1e5);
    for tau in [1.0 / (TAU * 30.0), (m / k).sqrt(), 1e-4] {
        for b_m in [0.0, 350.0] {
            // The source's unit is speed: its gain b_m is divided out, so that the loop gain is that of a
            // force.
            let drive = if b_m > 0.0 { Drive::VelocitySource(b_m, tau) } else { Drive::Lag(tau) };
            let plant = rigid(m, b, k, drive).system();
            let plant = if b_m > 0.0 { plant.scaled(1.0 / b_m) } else { plant };
            let stable = AffineLoop::negative_feedback(&plant).unwrap().stable_gains().unwrap();
            let edge = stable.intervals[0].upper.as_ref().unwrap();
            // Routh: (1/tau + b/m)(b/(m tau) + k/m + b_m/(m tau)) = (k + k K)/(m tau).
            let routh = (1.0 / tau + b / m) * (b + tau * k + b_m) / k - 1.0;
            assert!((edge.gain / routh - 1.0).abs() < EDGE, "{} against {routh}", edge.gain);
            let omega = ((b + b_m + tau * k) / (tau * m)).sqrt();
            assert!((edge.frequency_hz * TAU / omega - 1.0).abs() < EDGE);
            if b_m <= 0.0 {
                let printed = b / (tau * k) + tau * b / m + b * b / (m * k);
                assert!((edge.gain / printed - 1.0).abs() < EDGE);
            }
        }
    }
    let plant = rigid(m, b, k, Drive::Lag(1.0 / (TAU * 30.0))).system();
    let stable = AffineLoop::negative_feedback(&plant).unwrap().stable_gains().unwrap();
    let edge = stable.intervals[0].upper.as_ref().unwrap();
    // Half a unit of the last printed digit.
    assert!((edge.gain - 0.450_043).abs() < 0.5e-6 && (edge.frequency_hz - 13.206).abs() < 0.5e-3);
}

/// Form B: an undamped two-mass axis; `1 + K* = (m1 (k + k_s) + m2 k)^2 / (4 m1 m2 k k_s)`. Poles meet on the
/// imaginary axis there.
#[test]
fn truth_b_undamped_two_mass_axis() {
    let (m1, m2, k, ks) = (12.0, 8.0, 4e5, 1e5);
    let axis = Axis {
        masses: (m1, m2),
        guide_damping: 0.0,
        contact: (ks, 0.0),
        transmission: Some((k, 0.0)),
        base: None,
        workpiece: None,
        drive: Drive::Ideal,
        total_force: false,
    };
    let family = AffineLoop::negative_feedback(&axis.system()).unwrap();
    // Below K* no motion decays or grows; beyond it growth rises as a square root, so 1e-4 1/s moves the edge
    // by about 1e-12.
    let search = GainSearch { growth_limit_per_s: 1e-4, ..GainSearch::non_negative(1.0).unwrap() };
    let stable = stable_gains(Continuous, |gain| family.at(gain), &search).unwrap();
    let edge = stable.intervals[0].upper.as_ref().unwrap();
    let truth = (m1 * (k + ks) + m2 * k).powi(2) / (4.0 * m1 * m2 * k * ks) - 1.0;
    assert!((edge.gain / truth - 1.0).abs() < EDGE, "{} against {truth}", edge.gain);
    assert!((edge.gain - 4.510_417).abs() < 0.5e-6);
}

/// Form C: undamped zeros of base and workpiece, exactly at `sqrt(k_b / (m_r + m_b))` and `sqrt(k_w / m_w)`.
#[test]
fn truth_c_zeros_of_base_and_workpiece() {
    let (mr, mb, kb, mw, kw) = (12.0, 180.0, 1.02e6, 3.0, 1.5e6);
    let rigid = || rigid(mr, 0.0, 2e5, Drive::Ideal);
    let base = Axis { base: Some((mb, kb, 0.0)), ..rigid() }.system().zeros().unwrap();
    let work = Axis { workpiece: Some((mw, kw, 0.0)), ..rigid() }.system().zeros().unwrap();
    for (zeros, squared) in [(base, kb / (mr + mb)), (work, kw / mw)] {
        let truth: f64 = squared;
        assert_eq!(zeros.len(), 2);
        // A dozen roundings.
        assert!(
            zeros
                .iter()
                .all(|z| (z.norm() / truth.sqrt() - 1.0).abs() < 1e-14 && z.re.abs() < 1e-12 * truth.sqrt()),
            "{zeros:?}"
        );
    }
}

/// Form D: an integral force loop on a pure stiffness with n samples of delay; T G k < 2 sin(pi / (2 (2 n +
/// 1))).
#[test]
fn truth_d_integral_loop_with_delay() {
    for n in 0..4_usize {
        // f[k+1] = f[k] - g f[k-n], g = T G k, as a chain of n old samples.
        let order = n + 1;
        let a0 = DMatrix::from_fn(order, order, |i, j| f64::from(u8::from(i == j + 1 || (i == 0 && j == 0))));
        let a1 = DMatrix::from_fn(order, order, |i, j| if i == 0 && j == n { -1.0 } else { 0.0 });
        let domain = feeler_lti::Discrete::new(1e-3).unwrap();
        let stable = AffineLoop::new(a0, a1, domain).unwrap().stable_gains().unwrap();
        assert_eq!(stable.intervals.len(), 1);
        let interval = &stable.intervals[0];
        let (lower, upper) = (interval.lower.as_ref().unwrap(), interval.upper.as_ref().unwrap());
        let truth = 2.0 * (PI / (2.0 * (2 * n + 1) as f64)).sin();
        assert!(lower.gain.abs() < EDGE);
        assert!((upper.gain / truth - 1.0).abs() < EDGE, "{} against {truth}", upper.gain);
        let printed = [2.0, 1.0, 0.618_034, 0.445_042][n];
        assert!((upper.gain - printed).abs() < 0.5e-6);
    }
}

/// Form D again, through the exact discretisation with delay of an integrator under hold.
#[test]
fn truth_d_integral_loop_through_the_hold() {
    let integrator = StateSpace::new(dmatrix![0.0], dmatrix![1.0], dmatrix![1.0], dmatrix![0.0]).unwrap();
    let period_s = 2e-3;
    for n in 0..4_u32 {
        let sampled = integrator.zero_order_hold_delayed(period_s, period_s * f64::from(n)).unwrap();
        let stable = AffineLoop::negative_feedback(&sampled).unwrap().stable_gains().unwrap();
        let truth = 2.0 * (PI / f64::from(2 * (2 * n + 1))).sin() / period_s;
        assert!((stable.intervals[0].upper.as_ref().unwrap().gain / truth - 1.0).abs() < EDGE);
    }
}

/// Form E: under a hold an undamped axis is unstable for every gain and at every rate.
#[test]
fn truth_e_hold_destabilises_an_undamped_axis() {
    let plant = rigid(10.0, 0.0, 1e5, Drive::Ideal).system();
    for period_s in [1e-4, 1e-3, 7e-3] {
        let sampled = plant.zero_order_hold(period_s).unwrap();
        for gain in [1e-3, 0.1, 1.0, 10.0] {
            let closed = sampled.a() - sampled.b() * sampled.c() * gain;
            let growth =
                feeler_lti::eigenvalues(&closed).unwrap().iter().map(|z| z.norm()).fold(0.0, f64::max);
            assert!(growth > 1.0 + 1e-9, "gain {gain} at {period_s} s: {growth}");
        }
    }
}

/// A rigid axis with damping under PI control of fixed integral gain: `m s^3 + b s^2 + k (1 + K) s + k k_i`.
/// It is stable for all gains with `b (1 + K) > m k_i`, though its slowest pole approaches the border as
/// `-k_i / K`.
#[test]
fn regress_a_pole_that_creeps_to_the_border_is_no_edge() {
    let (m, b, k, k_i) = (12.0, 60.0, 2e5, 10.0);
    let a = |gain: f64| dmatrix![0.0, 1.0, 0.0; -k * (1.0 + gain) / m, -b / m, -k * k_i / m; 1.0, 0.0, 0.0];
    let stable =
        stable_gains(Continuous, a, &GainSearch { decades: 12, ..GainSearch::non_negative(1.0).unwrap() })
            .unwrap();
    assert_eq!(stable.intervals.len(), 1);
    assert!(stable.intervals[0].upper.is_none(), "{stable:?}");
    let lower = stable.intervals[0].lower.as_ref().unwrap().gain;
    assert!((lower - (m * k_i / b - 1.0)).abs() < EDGE, "{lower}");
}
