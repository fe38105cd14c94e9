//! Minimum of a quadratic function within bounds, by active sets.
//!
//! Clamping the free solution is not enough. If one of two coupled unknowns is held at its bound, the step of
//! the other no longer fits and may lead uphill.

use nalgebra::{DMatrix, DVector};

/// The `x` between `low` and `high` that minimises `x^T a x / 2 - b^T x`; `None` if `a` is not positive
/// definite. Zero must be within the bounds.
pub(crate) fn minimise(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    low: &[f64],
    high: &[f64],
) -> Option<DVector<f64>> {
    let n = b.len();
    let mut x = DVector::zeros(n);
    let mut held = vec![false; n];
    // Every iteration holds or releases an unknown; only rounding errors can repeat an active set.
    for _ in 0..=3 * n {
        let free: Vec<usize> = (0..n).filter(|&i| !held[i]).collect();
        let taken = |i: usize| (0..n).filter(|&j| held[j]).map(|j| a[(i, j)] * x[j]).sum::<f64>();
        let reduced = DMatrix::from_fn(free.len(), free.len(), |i, j| a[(free[i], free[j])]);
        let right = DVector::from_iterator(free.len(), free.iter().map(|&i| b[i] - taken(i)));
        let solved = reduced.cholesky()?.solve(&right);
        let mut is_within = true;
        for (&i, &value) in free.iter().zip(solved.iter()) {
            x[i] = value.clamp(low[i], high[i]);
            if value < low[i] || value > high[i] {
                held[i] = true;
                is_within = false;
            }
        }
        if is_within {
            let slope = a * &x - b;
            // Derivative with which the cost falls as an unknown at its bound moves inside.
            let inward = |i: usize| if x[i] <= low[i] { -slope[i] } else { slope[i] };
            let loosest = (0..n)
                .filter(|&i| held[i] && low[i] < high[i])
                .max_by(|&i, &j| inward(i).total_cmp(&inward(j)));
            match loosest.filter(|&i| inward(i) > 0.0) {
                Some(i) => held[i] = false,
                None => break,
            }
        }
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding error of a few sums.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn truth_a_held_unknown_takes_its_partner_along() {
        // Two unknowns with nearly the same effect. The free solution has large values of opposite sign. If
        // one is held at its bound, the other has their sum's effect.
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 0.99, 0.99, 1.0]);
        let b = DVector::from_row_slice(&[1.0, 0.5]);
        let x = minimise(&a, &b, &[-10.0, 0.0], &[10.0, 10.0]).unwrap();
        assert!(x[1].abs() < ROUNDING && (x[0] - 1.0).abs() < ROUNDING);
    }

    #[test]
    fn truth_within_the_bounds_it_is_the_free_solution() {
        let a = DMatrix::from_row_slice(2, 2, &[2.0, 0.5, 0.5, 1.0]);
        let x = minimise(&a, &(&a * DVector::from_row_slice(&[0.3, -0.2])), &[-1.0; 2], &[1.0; 2]).unwrap();
        assert!((x[0] - 0.3).abs() < ROUNDING && (x[1] + 0.2).abs() < ROUNDING);
    }

    #[test]
    fn prop_no_small_move_within_the_bounds_is_lower() {
        let mut state: u64 = 5;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for _ in 0..300 {
            let n = 5;
            let root = DMatrix::from_fn(n, n, |_, _| draw());
            let a = &root * root.transpose() + 1e-3 * DMatrix::identity(n, n);
            let b = DVector::from_fn(n, |_, _| draw());
            let (low, high): (Vec<f64>, Vec<f64>) =
                (0..n).map(|_| (draw().min(0.0), draw().max(0.0))).unzip();
            let x = minimise(&a, &b, &low, &high).unwrap();
            let slope = &a * &x - &b;
            for i in 0..n {
                assert!(x[i] >= low[i] && x[i] <= high[i]);
                // At the minimum no unknown can lower the cost by moving inside its bounds. The matrix
                // amplifies rounding errors a thousandfold.
                assert!(x[i] >= high[i] || slope[i] > -1e3 * ROUNDING);
                assert!(x[i] <= low[i] || slope[i] < 1e3 * ROUNDING);
            }
        }
    }
}
