//! Random chains of masses and springs over four decades, whose zeros are known by mechanics.

use feeler_lti::{C64, LoopTransfer, StateSpace};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// A chain of bodies from ground: spring i joins body i - 1 (ground for i = 0) to body i. SI units.
#[derive(Debug, Clone)]
struct Chain {
    masses: Vec<f64>,
    stiffnesses: Vec<f64>,
    dampings: Vec<f64>,
}

impl Chain {
    /// From a force on one body to the displacement of another.
    fn system(&self, driven: usize, seen: usize) -> StateSpace {
        let n = self.masses.len();
        let mut a = DMatrix::zeros(2 * n, 2 * n);
        a.view_mut((0, n), (n, n)).fill_with_identity();
        for (i, (k, c)) in self.stiffnesses.iter().zip(&self.dampings).enumerate() {
            let direction = DVector::from_fn(n, |j, _| f64::from(i8::from(j == i) - i8::from(j + 1 == i)));
            for (row, mass) in self.masses.iter().enumerate() {
                for column in 0..n {
                    let product = direction[row] * direction[column] / mass;
                    a[(n + row, column)] -= product * k;
                    a[(n + row, n + column)] -= product * c;
                }
            }
        }
        let mut b = DMatrix::zeros(2 * n, 1);
        b[(n + driven, 0)] = 1.0 / self.masses[driven];
        let mut c = DMatrix::zeros(1, 2 * n);
        c[(0, seen)] = 1.0;
        StateSpace::new(a, b, c, DMatrix::zeros(1, 1)).unwrap()
    }

    /// Squared natural frequencies (rad/s)^2, rising, with one body held; undamped.
    fn held_squared(&self, held: usize) -> Vec<f64> {
        let n = self.masses.len();
        let free: Vec<usize> = (0..n).filter(|i| *i != held).collect();
        // M^-1/2 K M^-1/2 is symmetric, so its eigenvalues come from another method than those of the state
        // matrix.
        let stiffness = |i: usize, j: usize| {
            let above = self.stiffnesses.get(i.max(j) + usize::from(i == j)).copied().unwrap_or(0.0);
            let between = |k: usize| self.stiffnesses[k];
            match i.abs_diff(j) {
                0 => self.stiffnesses[i] + above,
                1 => -between(i.max(j)),
                _ => 0.0,
            }
        };
        let scaled = |i: usize, j: usize| {
            stiffness(free[i], free[j]) / (self.masses[free[i]] * self.masses[free[j]]).sqrt()
        };
        let mut values: Vec<f64> =
            DMatrix::from_fn(n - 1, n - 1, scaled).symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        values
    }
}

fn chain() -> impl Strategy<Value = Chain> {
    (2_usize..8).prop_flat_map(|n| {
        let decades =
            |low: f64, high: f64| proptest::collection::vec((low..high).prop_map(|e| 10_f64.powf(e)), n);
        (decades(-1.0, 3.0), decades(3.0, 7.0), decades(0.0, 3.0))
            .prop_map(|(masses, stiffnesses, dampings)| Chain { masses, stiffnesses, dampings })
    })
}

/// A spring of 100 kN/m with 10 N s/m has its zero at -1e4 1/s. Each body held leaves the motions of both
/// sides.
#[test]
fn truth_zeros_of_a_long_chain_are_those_of_its_springs() {
    for n in [12, 24, 100] {
        let chain = Chain { masses: vec![1.0; n], stiffnesses: vec![1e5; n], dampings: vec![10.0; n] };
        let whole = chain.system(0, n - 1);
        let zeros = whole.zeros().unwrap();
        assert_eq!(zeros.len(), n - 1);
        // Each zero is -k / c of a subsystem with one state, accurate to a few roundings.
        assert!(zeros.iter().all(|z| (z + 1e4).norm() < 1e-14 * 1e4), "{n}: {zeros:?}");
        // At high frequency the force of every spring is c s per displacement.
        let form = whole.zero_pole_gain().unwrap();
        let truth = 10_f64.powi(i32::try_from(n).unwrap() - 1);
        assert!((form.leading_coefficient / truth - 1.0).abs() < 1e-12, "{n}: {}", form.leading_coefficient);
        let held = chain.system(n / 2, n / 2).zeros().unwrap();
        assert_eq!(held.len(), 2 * (n - 1));
        assert!(held.iter().all(|z| z.re < 0.0 && z.norm() < 2.0 * 1e5_f64.sqrt()), "{n}: {held:?}");
    }
}

/// Within a millisecond a force passes some bodies of a long chain and is lost in rounding behind them. So
/// the zeros of the sampled chain are not numbers. It still has poles, and a slow force bends the spring to
/// ground.
#[test]
fn regress_a_sampled_chain_of_a_hundred_bodies_has_a_loop() {
    let n = 100;
    let chain = Chain { masses: vec![1.0; n], stiffnesses: vec![1e5; n], dampings: vec![10.0; n] };
    let sampled = chain.system(0, n - 1).zero_order_hold(1e-3).unwrap();
    let transfer = LoopTransfer::discrete(&sampled).unwrap();
    assert_eq!(transfer.unstable_poles(), 0);
    let slow = transfer.at_frequency(0.0).unwrap();
    // Rounding of the transition matrix, divided by the square of the slowest mode's angle per sample.
    assert!((slow * 1e5 - 1.0).norm() < 1e-8, "{slow}");
}

/// Relative accuracy of zeros in the scale of the fastest motion: the rounding of a matrix with frequencies
/// over four decades.
const ROUNDING: f64 = 1e-11;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// If drive and sensor are on the same body, the zeros are the resonances of the rest with that body
    /// held.
    #[test]
    fn prop_colocated_zeros_are_resonances_with_the_body_held(chain in chain(), choice in 0_usize..100) {
        let body = choice % chain.masses.len();
        let undamped = Chain { dampings: vec![0.0; chain.masses.len()], ..chain };
        let zeros = undamped.system(body, body).zeros().unwrap();
        prop_assert_eq!(zeros.len(), 2 * (undamped.masses.len() - 1));
        let mut squared: Vec<f64> = zeros.iter().filter(|z| z.im > 0.0).map(C64::norm_sqr).collect();
        squared.sort_by(f64::total_cmp);
        let truth = undamped.held_squared(body);
        prop_assert_eq!(squared.len(), truth.len(), "{:?}", zeros);
        let fastest = truth[truth.len() - 1];
        for (found, truth) in squared.iter().zip(&truth) {
            prop_assert!((found - truth).abs() <= ROUNDING * fastest, "{found} {truth}");
        }
    }

    /// From one end to the other every spring must carry the force: the only zeros are those of the springs,
    /// -k/c.
    #[test]
    fn prop_end_to_end_zeros_are_those_of_the_springs(chain in chain()) {
        let n = chain.masses.len();
        let zeros = chain.system(0, n - 1).zeros().unwrap();
        let mut truth: Vec<f64> = (1..n).map(|i| -chain.stiffnesses[i] / chain.dampings[i]).collect();
        truth.sort_by(|a, b| b.total_cmp(a));
        prop_assert_eq!(zeros.len(), truth.len(), "{:?} {:?}", zeros, truth);
        for expected in truth {
            let nearest = zeros.iter().map(|z| (z - expected).norm()).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest <= 1e-5 * expected.abs(), "{expected} is not in {zeros:?}");
        }
    }

    /// Without damping there is no zero from end to end: an infinite zero of multiplicity up to 14 must leave
    /// no trace.
    #[test]
    fn prop_undamped_chain_has_no_zero_end_to_end(chain in chain()) {
        let n = chain.masses.len();
        let undamped = Chain { dampings: vec![0.0; n], ..chain };
        prop_assert_eq!(undamped.system(0, n - 1).zeros().unwrap(), Vec::new());
    }
}
