//! Eigenvectors from a Schur form by back substitution.

use nalgebra::{DMatrix, DVector};

use crate::domain::C64;
use crate::francis::{Rows, Schur, schur_by_francis};

/// Entries beyond this are scaled down before they overflow.
const LARGE: f64 = 1e100;

/// Eigenvalues with right eigenvectors (not of unit length) of a balanced matrix, in no order; `None` if the
/// iteration does not converge. Pairs are exactly conjugate.
///
/// Source: Golub and Van Loan, Matrix Computations, section 7.6.4.
pub(crate) fn eigenpairs(matrix: &DMatrix<f64>) -> Option<Vec<(C64, DVector<C64>)>> {
    let schur = schur_by_francis(matrix)?;
    let t = &schur.form;
    let norm = t.norm();
    let smallest = f64::EPSILON * if norm > 0.0 { norm } else { 1.0 };
    let mut found = Vec::with_capacity(t.order);
    for (position, &(low, is_pair)) in schur.blocks.iter().enumerate() {
        let of = |value: C64, start: &[(usize, C64)]| {
            vector(&schur, &schur.blocks[position + 1..], value, start, smallest)
        };
        if is_pair {
            let [lower, upper] = t.pair(low);
            let first = of(lower, &null_of_pair(t, low, lower));
            let second =
                if upper.im > 0.0 { first.conjugate() } else { of(upper, &null_of_pair(t, low, upper)) };
            found.extend([(lower, first), (upper, second)]);
        } else {
            let value = C64::from(t.at(low, low));
            found.push((value, of(value, &[(low, C64::ONE)])));
        }
    }
    for (value, _) in &mut found {
        *value *= schur.unit;
    }
    found.iter().all(|(value, v)| value.is_finite() && v.iter().all(|x| x.is_finite())).then_some(found)
}

/// A vector that the block of rows `low` and `low + 1` maps to `value` times itself, from its larger row.
fn null_of_pair(t: &Rows, low: usize, value: C64) -> [(usize, C64); 2] {
    let upper = [C64::from(t.at(low, low + 1)), value - t.at(low, low)];
    let lower = [value - t.at(low + 1, low + 1), C64::from(t.at(low + 1, low))];
    let size = |v: &[C64; 2]| v[0].norm() + v[1].norm();
    let [x, y] = if size(&upper) >= size(&lower) { upper } else { lower };
    [(low, x), (low + 1, y)]
}

/// The eigenvector that equals `start` in its own block; the blocks above follow from (T - value) x = 0. A
/// pivot that is only rounding is replaced by `smallest`.
fn vector(
    schur: &Schur,
    above: &[(usize, bool)],
    value: C64,
    start: &[(usize, C64)],
    smallest: f64,
) -> DVector<C64> {
    let t = &schur.form;
    let mut x = DVector::from_element(t.order, C64::ZERO);
    for &(row, entry) in start {
        x[row] = entry;
    }
    let mut end = start.iter().map(|(row, _)| row + 1).max().unwrap_or(0);
    for &(low, is_pair) in above {
        let known = low + 1 + usize::from(is_pair);
        let sum = |row: usize| (known..end).map(|j| x[j] * t.at(row, j)).sum::<C64>();
        if is_pair {
            let (first, second) = (sum(low), sum(low + 1));
            let (a, b) = (t.at(low, low) - value, t.at(low, low + 1));
            let (c, d) = (t.at(low + 1, low), t.at(low + 1, low + 1) - value);
            // Products of values relative to this size neither overflow nor vanish.
            let size = a.norm() + b.abs() + c.abs() + d.norm();
            let (a, b, c, d) = (a / size, b / size, c / size, d / size);
            let determinant = a * d - b * c;
            let least = smallest / size;
            let determinant = if determinant.norm() < least { C64::from(least) } else { determinant };
            x[low] = (second * b - first * d) / determinant / size;
            x[low + 1] = (first * c - second * a) / determinant / size;
        } else {
            let pivot = t.at(low, low) - value;
            x[low] = -sum(low) / if pivot.norm() < smallest { C64::from(smallest) } else { pivot };
        }
        let size = x[low].norm().max(x[known - 1].norm());
        if size > LARGE {
            x /= C64::from(size);
        }
        end = end.max(known);
    }
    schur.basis.map(C64::from) * x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of a backward stable method, some n eps |A|.
    const ROUNDING: f64 = 1e-13;

    fn residual(a: &DMatrix<f64>) -> f64 {
        let complex = a.map(C64::from);
        let pairs = eigenpairs(a).unwrap();
        assert_eq!(pairs.len(), a.nrows());
        pairs
            .iter()
            .map(|(value, v)| (&complex * v - v * *value).norm() / (complex.norm().max(1.0) * v.norm()))
            .fold(0.0, f64::max)
    }

    #[test]
    fn truth_vectors_satisfy_their_equation() {
        for n in 1..=60 {
            let entry = |i: usize, j: usize| {
                let mixed = (1 + i * 127 + j * 311 + n * 7919) as f64;
                2.0 * (mixed.sin() * 43_758.545_3).rem_euclid(1.0) - 1.0
            };
            let far = residual(&DMatrix::from_fn(n, n, entry));
            assert!(far < ROUNDING, "{n}: {far}");
        }
    }

    #[test]
    fn truth_equal_eigenvalues_keep_the_equation() {
        let jordan =
            DMatrix::from_fn(5, 5, |i, j| if i == j { 2.0 } else { f64::from(u8::from(j == i + 1)) });
        assert!(residual(&jordan) < ROUNDING);
        assert!(residual(&DMatrix::identity(4, 4)) < ROUNDING);
        assert!(residual(&DMatrix::zeros(3, 3)) < ROUNDING);
        let double = DMatrix::from_fn(4, 4, |i, j| match (i, j) {
            (0, 1 | 2) | (1 | 2, 3) => 1.0,
            (1, 0) | (3, 2) => -4.0,
            _ => 0.0,
        });
        assert!(residual(&double) < ROUNDING);
    }
}
