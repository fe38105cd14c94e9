//! Laws that hold for all systems, tested on random ones.

use feeler_lti::{AffineLoop, C64, LoopTransfer, StateSpace, TimeDomain, eigenvalues, expm, root_locus};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// A system of order 1 to 5, stable in most cases: a random matrix, shifted left by 0.1 plus 0.6 times its
/// norm. Rates are multiples of the scale.
fn stable_system(scale: f64) -> impl Strategy<Value = StateSpace> {
    (1_usize..6).prop_flat_map(move |n| {
        let entries = |count: usize| proptest::collection::vec(-1.0_f64..1.0, count);
        (entries(n * n), entries(n), entries(n), -1.0_f64..1.0).prop_map(move |(a, b, c, d)| {
            let a = DMatrix::from_vec(n, n, a);
            // The Frobenius norm bounds every eigenvalue, and most lie far inside the bound.
            let shift = DMatrix::<f64>::identity(n, n) * (a.norm() * 0.6 + 0.1);
            let a = (a - shift) * scale;
            let b = DMatrix::from_vec(n, 1, b) * scale;
            StateSpace::new(a, b, DMatrix::from_vec(1, n, c), DMatrix::from_element(1, 1, d)).unwrap()
        })
    })
}

/// Growth rates (1/s) of the loop u = -k y.
fn growth_rates<T: TimeDomain>(system: &StateSpace<T>, gain: f64) -> Vec<f64> {
    let closed = AffineLoop::negative_feedback(system).unwrap().at(gain);
    eigenvalues(&closed).unwrap().into_iter().map(|p| system.domain().growth_per_s(p)).collect()
}

/// A motion that grows or decays by less than this (1/s) is too close to the edge for a comparison. The
/// systems have rates of about 100 1/s.
const UNDECIDED_PER_S: f64 = 1e-6;

fn check_gains<T: TimeDomain>(system: &StateSpace<T>, exponents: &[f64]) -> Result<(), TestCaseError> {
    let stable = AffineLoop::negative_feedback(system).unwrap().stable_gains().unwrap();
    for exponent in exponents {
        let gain = 10_f64.powf(*exponent);
        let growth = growth_rates(system, gain).into_iter().fold(f64::NEG_INFINITY, f64::max);
        if growth.abs() > UNDECIDED_PER_S {
            let inside = stable.nearest(gain).is_some_and(|interval| interval.distance(gain) <= 0.0);
            prop_assert_eq!(inside, growth < 0.0, "gain {} grows with {}, {:?}", gain, growth, stable);
        }
    }
    Ok(())
}

fn check_count<T: TimeDomain>(
    system: &StateSpace<T>,
    transfer: &LoopTransfer<T>,
    gain: f64,
) -> Result<(), TestCaseError> {
    let growth = growth_rates(system, gain);
    if growth.iter().all(|g| g.abs() > UNDECIDED_PER_S) {
        let unstable = growth.iter().filter(|g| **g > 0.0).count();
        prop_assert_eq!(transfer.closed_loop_unstable_poles(gain).unwrap(), unstable);
    }
    Ok(())
}

/// The system without direct feed-through.
fn without_feed_through(system: &StateSpace) -> StateSpace {
    let (a, b, c) = (system.a().clone(), system.b().clone(), system.c().clone());
    StateSpace::new(a, b, c, DMatrix::zeros(1, 1)).unwrap()
}

/// Frequency response (1 - exp(-s T)) / (s T) of a zero-order hold at s, including the sampler's factor 1 /
/// T; 1 at s = 0.
fn zero_order_hold_response(s: C64, period_s: f64) -> C64 {
    let x = s * period_s;
    if x.norm() < 1e-4 {
        // Series: the next term, x^4 / 120, is below rounding.
        return C64::new(1.0, 0.0) - x / 2.0 + x * x / 6.0 - x * x * x / 24.0;
    }
    (C64::new(1.0, 0.0) - (-x).exp()) / x
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// exp(A (s + t)) = exp(A s) exp(A t). The spans are at most sixteen time constants, so a few hundred
    /// roundings.
    #[test]
    fn prop_exponential_is_a_semigroup(
        system in stable_system(50.0),
        s in 1e-4_f64..0.1,
        t in 1e-4_f64..0.1,
    ) {
        let e = |time: f64| expm(&(system.a() * time)).unwrap();
        let (whole, parts) = (e(s + t), e(s) * e(t));
        prop_assert!((&whole - &parts).amax() <= 1e-13 * whole.amax().max(1.0));
    }

    /// A delay of whole quarters of a sample equals whole samples at four times the rate.
    #[test]
    fn prop_fractional_delay_equals_fine_sampling(
        system in stable_system(300.0),
        quarters in 0_u32..11,
        input in proptest::collection::vec(-1.0_f64..1.0, 12),
    ) {
        let period_s = 4e-3;
        let coarse = system.zero_order_hold_delayed(period_s, period_s * f64::from(quarters) / 4.0).unwrap();
        let fine = system.zero_order_hold(period_s / 4.0).unwrap();
        let zero = |n: usize| DVector::zeros(n);
        let samples = DMatrix::from_row_slice(1, input.len(), &input);
        let found = coarse.respond(&zero(coarse.states()), &samples).unwrap();
        let at = |i: usize| i.checked_sub(quarters as usize).map_or(0.0, |i| input[i / 4]);
        let held = DMatrix::from_fn(1, 4 * input.len(), |_, i| at(i));
        let truth = fine.respond(&zero(fine.states()), &held).unwrap();
        for k in 0..input.len() {
            prop_assert!((found[(0, k)] - truth[(0, 4 * k)]).abs() < 1e-12 * (1.0 + truth.amax()));
        }
    }

    /// The sampled response to a held input is the sum of the aliases of hold times plant (Poisson). Without
    /// feed-through they fall as 1/k^2.
    #[test]
    fn prop_sampled_response_is_the_sum_of_its_aliases(
        system in stable_system(300.0),
        share in 0.05_f64..0.9,
    ) {
        let period_s = 1e-3;
        let system = without_feed_through(&system);
        let sampled = system.zero_order_hold(period_s).unwrap();
        let w = share * sampled.domain().nyquist_rad_per_s();
        let direct = sampled.at(sampled.domain().boundary_point(w)).unwrap()[(0, 0)];
        let alias = |k: i32| {
            let s = C64::new(0.0, w + std::f64::consts::TAU / period_s * f64::from(k));
            zero_order_hold_response(s, period_s) * system.at(s).unwrap()[(0, 0)]
        };
        let sum: C64 = (1..1000).map(|k| alias(k) + alias(-k)).sum::<C64>() + alias(0);
        // The tail beyond 1000 aliases is of order |C B| T / (pi^2 1000).
        let bound = 1e-3 * period_s * (system.c() * system.b()).amax() + 1e-12;
        prop_assert!((direct - sum).norm() < bound, "{direct} {sum}");
    }

    /// The response is zero at each zero and infinite at each pole. Both lists together reproduce it.
    #[test]
    fn prop_zeros_and_poles_by_substitution(system in stable_system(100.0), angle in 0.0_f64..6.0) {
        let form = system.zero_pole_gain().unwrap();
        let away = C64::from_polar(150.0, angle);
        let (direct, factored) = (system.at(away).unwrap()[(0, 0)], form.at(away));
        prop_assert!((direct - factored).norm() < 1e-9 * direct.norm(), "{direct} {factored}");
        for zero in &form.zeros {
            // Newton's step from a zero, H / H', is the error of the substitution in units of s. Beyond 1e6
            // times the rates D is almost zero.
            if zero.norm() < 1e6 {
                let evaluator = feeler_lti::TransferEvaluator::new(&system);
                if let Ok((value, slope)) = evaluator.with_derivative(*zero) {
                    let step = value[(0, 0)].norm() / slope[(0, 0)].norm();
                    prop_assert!(step < 1e-5 * zero.norm().max(1.0), "{zero}: {step:e}");
                }
            }
        }
    }

    /// Series and feedback are product and L / (1 + L B) of responses.
    #[test]
    fn prop_connections_are_algebra(
        first in stable_system(10.0),
        second in stable_system(10.0),
        w in 0.1_f64..100.0,
    ) {
        let s = C64::new(0.3, w);
        let at = |system: &StateSpace| system.at(s).unwrap()[(0, 0)];
        let (g, h) = (at(&first), at(&second));
        prop_assert!((at(&first.series(&second).unwrap()) - g * h).norm() < 1e-11 * (1.0 + (g * h).norm()));
        let difference = 1.0 + first.d()[(0, 0)] * second.d()[(0, 0)];
        prop_assume!(difference.abs() > 0.1);
        let truth = g / (1.0 + g * h);
        prop_assert!((at(&first.feedback(&second).unwrap()) - truth).norm() < 1e-9 * (1.0 + truth.norm()));
    }

    /// A gain lies in one of the stable intervals exactly if the closed loop's eigenvalues are stable. The
    /// search misses no interval or gap.
    #[test]
    fn prop_stable_gains_agree_with_eigenvalues(
        system in stable_system(100.0),
        period_share in 0.0_f64..1.0,
        exponents in proptest::collection::vec(-3.0_f64..5.0, 40),
    ) {
        let system = without_feed_through(&system);
        let sampled = system.zero_order_hold_delayed(1e-3, 2e-3 * period_share).unwrap();
        check_gains(&system, &exponents)?;
        check_gains(&sampled, &exponents)?;
    }

    /// Nyquist's count uses only the response, and its number of unstable poles equals that of the
    /// eigenvalues.
    #[test]
    fn prop_nyquist_count_equals_eigenvalues(
        system in stable_system(100.0),
        gain in -300.0_f64..300.0,
        period_share in 0.0_f64..1.0,
    ) {
        let system = without_feed_through(&system);
        let sampled = system.zero_order_hold_delayed(1e-3, 2e-3 * period_share).unwrap();
        check_count(&system, &LoopTransfer::continuous(&system, 0.0).unwrap(), gain)?;
        check_count(&sampled, &LoopTransfer::discrete(&sampled).unwrap(), gain)?;
    }

    /// Branches of a root locus hold the eigenvalues of the loop at every gain. They move little in a small
    /// step.
    #[test]
    fn prop_root_locus_is_continuous(system in stable_system(10.0)) {
        let a = |k: f64| system.a() - system.b() * system.c() * k;
        let gains: Vec<f64> = (0..200).map(|i| f64::from(i) * 1e-3).collect();
        let locus = root_locus(a, &gains).unwrap();
        for (j, &gain) in gains.iter().enumerate() {
            let sum: C64 = locus.branches.iter().map(|b| b[j]).sum();
            prop_assert!((sum - a(gain).trace()).norm() < 1e-10 * (1.0 + sum.norm()));
        }
        // Eigenvalues of an n x n matrix move by at most about |dA|^(1/n) times the norm. Order 5 and 1e-3
        // give a quarter.
        let norm = system.a().norm() + system.b().norm() * system.c().norm();
        for branch in &locus.branches {
            prop_assert!(branch.windows(2).all(|p| (p[1] - p[0]).norm() < 0.5 * norm));
        }
    }
}
