//! Balancing by powers of two: a diagonal similarity that gives rows and columns of a matrix comparable norms
//! without any rounding.
//!
//! Source: Parlett and Reinsch, Numerische Mathematik 13 (1969); Osborne, JACM 7 (1960). Departure: a row (or
//! column) of zeros leaves the scale of its column (row) free. That scale is chosen so that the column (row)
//! does not exceed the rest of the matrix. Inputs appended to a state matrix are of this kind, and would
//! otherwise determine its norm.

use nalgebra::DMatrix;

/// A balanced matrix D^-1 M D and the diagonal of D.
#[derive(Debug, Clone, PartialEq)]
pub struct Balanced {
    /// D^-1 M D.
    pub matrix: DMatrix<f64>,
    /// Diagonal of D; every element is a power of two.
    pub scale: Vec<f64>,
}

/// Largest number of sweeps; convergence takes three or four.
const MAX_SWEEPS: usize = 50;
/// A change is made only if it reduces the sum of row and column norm by this factor (Parlett and Reinsch).
const WORTHWHILE: f64 = 0.95;
/// Scales stay within 2^+-400, so that neither they nor their quotients leave the range of doubles.
const MAX_EXPONENT: i32 = 400;

/// Balances a square matrix. Zeros stay exactly zero and the eigenvalues are unchanged.
///
/// # Panics
/// If the matrix is not square.
pub fn balance(matrix: &DMatrix<f64>) -> Balanced {
    assert_eq!(matrix.nrows(), matrix.ncols(), "only a square matrix can be balanced");
    let n = matrix.nrows();
    let mut m = matrix.clone();
    let mut exponents = vec![0_i32; n];
    for _ in 0..MAX_SWEEPS {
        let mut changed = false;
        for (i, exponent_of_i) in exponents.iter_mut().enumerate() {
            let (row, column) = off_diagonal_norms(&m, i);
            if row > 0.0 && column > 0.0 {
                // Nearest power of two to sqrt(row / column).
                let exponent = bounded(*exponent_of_i, (0.5 * (row / column).log2()).round());
                let f = 2_f64.powi(exponent);
                if exponent != 0 && column * f + row / f < WORTHWHILE * (column + row) {
                    rescale(&mut m, i, exponent);
                    *exponent_of_i += exponent;
                    changed = true;
                }
            }
        }
        if !changed {
            break;
        }
    }
    shrink_one_sided(&mut m, &mut exponents);
    Balanced { matrix: m, scale: exponents.into_iter().map(|e| 2_f64.powi(e)).collect() }
}

/// Reduces the nonzero partner of each zero row (column) until it does not exceed the rest of the matrix
/// without such pairs.
fn shrink_one_sided(m: &mut DMatrix<f64>, exponents: &mut [i32]) {
    let n = m.nrows();
    let one_sided: Vec<bool> = (0..n)
        .map(|i| {
            let (row, column) = off_diagonal_norms(m, i);
            (row > 0.0) != (column > 0.0)
        })
        .collect();
    let core = (0..n)
        .map(|j| {
            (0..n)
                .filter(|&i| i == j || !(one_sided[i] || one_sided[j]))
                .map(|i| m[(i, j)].abs())
                .sum::<f64>()
        })
        .fold(0.0, f64::max);
    if core <= 0.0 {
        return;
    }
    for i in 0..n {
        if !one_sided[i] {
            continue;
        }
        let (row, column) = off_diagonal_norms(m, i);
        let excess = (row.max(column) / core).log2().ceil().max(0.0);
        // D scales column i by f and row i by 1/f.
        let exponent = bounded(exponents[i], if column > 0.0 { -excess } else { excess });
        rescale(m, i, exponent);
        exponents[i] += exponent;
    }
}

/// 1-norms of row i and column i without the diagonal.
fn off_diagonal_norms(m: &DMatrix<f64>, i: usize) -> (f64, f64) {
    let mut row = 0.0;
    let mut column = 0.0;
    for j in (0..m.nrows()).filter(|&j| j != i) {
        row += m[(i, j)].abs();
        column += m[(j, i)].abs();
    }
    (row, column)
}

/// The requested change of an exponent, limited so that the total stays in range.
fn bounded(current: i32, wanted: f64) -> i32 {
    let limit = f64::from(MAX_EXPONENT);
    let total = (f64::from(current) + wanted).clamp(-limit, limit);
    total as i32 - current
}

fn rescale(m: &mut DMatrix<f64>, i: usize, exponent: i32) {
    let f = 2_f64.powi(exponent);
    m.column_mut(i).scale_mut(f);
    m.row_mut(i).scale_mut(1.0 / f);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::float_cmp, reason = "balancing by powers of two is exact")]
    fn truth_balancing_is_an_exact_similarity() {
        let m = DMatrix::from_row_slice(3, 3, &[0.0, 1e6, 3.0, -1e-5, 2.0, 0.0, 0.0, 0.0, 0.0]);
        let balanced = balance(&m);
        for i in 0..3 {
            for j in 0..3 {
                assert_eq!(balanced.matrix[(i, j)] * balanced.scale[i] / balanced.scale[j], m[(i, j)]);
            }
        }
        assert!(balanced.matrix.amax() < 10.0);
    }

    #[test]
    fn truth_a_large_input_column_does_not_set_the_norm() {
        let m = DMatrix::from_row_slice(2, 2, &[-1.0, 1e12, 0.0, 0.0]);
        assert!(balance(&m).matrix.amax() <= 1.0);
    }
}
