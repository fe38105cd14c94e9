//! Sums over rows of products of slopes: the curvature of a fit and its gradient. Slopes are stored per
//! unknown, each as a series over the rows.

use feeler_lanes::dispatch;
use nalgebra::{DMatrix, DVector};

/// Number of rows whose products are summed in parallel.
const ABREAST: usize = 32;

/// Adds `factor * sum_k w_k s_ki s_kj` to `a`.
pub(crate) fn add_curvature(a: &mut DMatrix<f64>, factor: f64, slopes: &[Vec<f64>], weights: &[f64]) {
    for (i, slope) in slopes.iter().enumerate() {
        let weighted = times(slope, weights);
        for (j, other) in slopes[..=i].iter().enumerate() {
            let product = factor * dot(&weighted, other);
            a[(i, j)] += product;
            if i != j {
                a[(j, i)] += product;
            }
        }
    }
}

/// Adds `factor * sum_k w_k s_ki t_kj` to `a`: like [`add_curvature`], with the slopes of two sets of
/// unknowns.
pub(crate) fn add_mixed(
    a: &mut DMatrix<f64>,
    factor: f64,
    slopes: &[Vec<f64>],
    others: &[Vec<f64>],
    weights: &[f64],
) {
    for (j, other) in others.iter().enumerate() {
        let weighted = times(other, weights);
        for (i, slope) in slopes.iter().enumerate() {
            a[(i, j)] += factor * dot(&weighted, slope);
        }
    }
}

/// Adds `factor * sum_k r_k s_ki` to `b`.
pub(crate) fn add_gradient(b: &mut DVector<f64>, factor: f64, slopes: &[Vec<f64>], residuals: &[f64]) {
    for (b, slope) in b.iter_mut().zip(slopes) {
        *b += factor * dot(slope, residuals);
    }
}

/// `sum_i s_ki x_i` for every row `k`.
pub(crate) fn along(slopes: &[Vec<f64>], x: &DVector<f64>, rows: usize) -> Vec<f64> {
    let mut sum = vec![0.0; rows];
    for (slope, x) in slopes.iter().zip(x.iter()).filter(|(_, x)| **x != 0.0) {
        dispatch(
            #[inline(always)]
            || sum.iter_mut().zip(slope).for_each(|(sum, s)| *sum += s * x),
        );
    }
    sum
}

pub(crate) fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    dispatch(
        #[inline(always)]
        || {
            let (a, b) = (a.chunks_exact(ABREAST), b.chunks_exact(ABREAST));
            let rest = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum::<f64>();
            let mut sums = [0.0; ABREAST];
            for (a, b) in a.zip(b) {
                for i in 0..ABREAST {
                    sums[i] += a[i] * b[i];
                }
            }
            rest + sums.iter().sum::<f64>()
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// There are more rows than are summed in parallel. All products and sums are integers, so they are
    /// exact.
    #[test]
    fn truth_sums_are_those_written_out() {
        let rows = 2 * ABREAST + 5;
        let slopes: Vec<Vec<f64>> =
            [3, 7].map(|m| (0..rows).map(|k| (k * m % 11) as f64 - 5.0).collect()).into();
        let weights: Vec<f64> = (0..rows).map(|k| (k % 4) as f64).collect();
        let sum = |of: &dyn Fn(usize) -> f64| (0..rows).map(of).sum::<f64>();
        let mut a = DMatrix::identity(2, 2);
        add_curvature(&mut a, 2.0, &slopes, &weights);
        let mut b = DVector::zeros(2);
        add_gradient(&mut b, 0.5, &slopes, &weights);
        let mut mixed = DMatrix::zeros(2, 1);
        add_mixed(&mut mixed, 1.0, &slopes, &slopes[1..], &weights);
        for i in 0..2 {
            for j in 0..2 {
                let expected = f64::from(i == j) + 2.0 * sum(&|k| weights[k] * slopes[i][k] * slopes[j][k]);
                assert_eq!(a[(i, j)].to_bits(), expected.to_bits());
            }
            assert_eq!(b[i].to_bits(), (0.5 * sum(&|k| weights[k] * slopes[i][k])).to_bits());
            assert_eq!(mixed[(i, 0)].to_bits(), sum(&|k| weights[k] * slopes[i][k] * slopes[1][k]).to_bits());
        }
        let moved = along(&slopes, &DVector::from_column_slice(&[2.0, -1.0]), rows);
        let expected: Vec<f64> = slopes[0].iter().zip(&slopes[1]).map(|(a, b)| 2.0 * a - b).collect();
        assert_eq!(moved, expected);
    }
}
