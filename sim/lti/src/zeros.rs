//! Transmission zeros: points at which the Rosenbrock system matrix loses rank.
//!
//! Zeros at infinity have high multiplicity in mechanics (a force acts on a speed that acts on a position
//! ...). Rounding moves a k-fold infinite zero to a finite radius of eps^(-1/k). The system is therefore
//! split into parts that have their zeros each by itself. From each, infinite zeros are removed by orthogonal
//! rank reduction (by the Markov parameters for one input and one output). The rest has an invertible
//! feed-through, whose elimination leaves an ordinary eigenvalue problem. Newton's method on the determinant
//! of the unreduced part then polishes each zero. Source: Emami-Naeini and Van Dooren, Automatica 18 (1982).

use nalgebra::DMatrix;

use crate::balance::balance;
use crate::domain::{C64, TimeDomain};
use crate::eigen::{eigenvalues, sort_by_modulus};
use crate::error::LtiError;
use crate::irreducible::parts;
use crate::polish::{MANY_STATES, Polish, Reduced};
use crate::state_space::StateSpace;

/// With several inputs or outputs, values below this multiple of (order x eps x norm) count as zero in the
/// reduction.
const RANK_ROUNDINGS: f64 = 16.0;

impl<T: TimeDomain> StateSpace<T> {
    /// Finite transmission (invariant) zeros, by rising modulus. They include decoupling zeros (poles that
    /// cannot be controlled or observed).
    ///
    /// # Errors
    /// [`LtiError::Degenerate`] if a single-input single-output transfer function is identically zero;
    /// [`LtiError::EigenvaluesNotConverged`].
    ///
    /// # Example
    /// ```
    /// use feeler_lti::StateSpace;
    /// use nalgebra::dmatrix;
    /// // (s + 3) / (s + 1)(s + 2)
    /// let system = StateSpace::new(dmatrix![-3.0, -2.0; 1.0, 0.0],
    ///     dmatrix![1.0; 0.0], dmatrix![1.0, 3.0], dmatrix![0.0])?;
    /// let zeros = system.zeros()?;
    /// assert_eq!(zeros.len(), 1);
    /// assert!((zeros[0].re + 3.0).abs() < 1e-14);
    /// # Ok::<(), feeler_lti::LtiError>(())
    /// ```
    pub fn zeros(&self) -> Result<Vec<C64>, LtiError> {
        let mut zeros = Vec::new();
        for part in parts(balanced_system(self)) {
            let (mut found, is_square) = zeros_of(&part)?;
            if is_square && (part.a.nrows() < MANY_STATES || !part.d.is_empty()) {
                Polish::new(&part).all(&mut found);
            }
            zeros.append(&mut found);
        }
        sort_by_modulus(&mut zeros);
        Ok(zeros)
    }

    /// Zeros for a picture, in a fraction of the time. Two errors remain. Each of m equal zeros is only found
    /// to within the m-th root of rounding. Rounding of large zeros may hide very small ones.
    ///
    /// # Errors
    ///
    /// # Errors
    /// As [`Self::zeros`].
    pub fn unpolished_zeros(&self) -> Result<Vec<C64>, LtiError> {
        let mut zeros = Vec::new();
        for part in parts(balanced_system(self)) {
            zeros.append(&mut zeros_of(&part)?.0);
        }
        sort_by_modulus(&mut zeros);
        Ok(zeros)
    }
}

/// Zeros as the eigenvalue problem gives them, and whether there are as many inputs as outputs.
fn zeros_of(system: &Reduced) -> Result<(Vec<C64>, bool), LtiError> {
    let (outputs, inputs) = system.d.shape();
    let reduced = match (outputs, inputs) {
        // Neither input nor output remains: the zeros are the poles of the remaining system.
        (0, 0) => system.clone(),
        (1, 1) => reduce_single(system).ok_or(LtiError::Degenerate)?,
        _ => {
            let total = system.a.norm() + system.b.norm() + system.c.norm() + system.d.norm();
            let tolerance =
                RANK_ROUNDINGS * (system.a.nrows() + inputs + outputs) as f64 * f64::EPSILON * total;
            let rows = reduce(system.clone(), tolerance);
            transpose(&reduce(transpose(&rows), tolerance))
        }
    };
    let is_square = inputs == outputs && reduced.d.ncols() == inputs;
    Ok((pencil_eigenvalues(&reduced)?, is_square))
}

/// The system with states, inputs and outputs scaled by powers of two, so that all parts of its matrix have
/// comparable size.
fn balanced_system<T: TimeDomain>(system: &StateSpace<T>) -> Reduced {
    let (n, m, p) = (system.states(), system.inputs(), system.outputs());
    let size = n + m.max(p);
    let mut whole = DMatrix::zeros(size, size);
    whole.view_mut((0, 0), (n, n)).copy_from(system.a());
    whole.view_mut((0, n), (n, m)).copy_from(system.b());
    whole.view_mut((n, 0), (p, n)).copy_from(system.c());
    whole.view_mut((n, n), (p, m)).copy_from(system.d());
    let whole = balance(&whole).matrix;
    Reduced {
        a: whole.view((0, 0), (n, n)).into_owned(),
        b: whole.view((0, n), (n, m)).into_owned(),
        c: whole.view((n, 0), (p, n)).into_owned(),
        d: whole.view((n, n), (p, m)).into_owned(),
    }
}

/// Removes the infinite zeros of a system with one input and one output. `None` if its transfer function is
/// zero.
///
/// Their number r is that of the first nonzero Markov parameter D, C B, C A B, ... Rounding is bounded by the
/// same product of moduli |C| |A|^k |B|. That bound holds for each element, so it stays sharp for machines
/// whose masses and springs differ by many decades. It is zero if no path leads from input to output. The
/// same number makes the feed-through of the reduced system exact.
fn reduce_single(system: &Reduced) -> Option<Reduced> {
    let n = system.a.nrows();
    let mut r = system.clone();
    if r.d[(0, 0)].abs() > 0.0 {
        return Some(r);
    }
    let (a_modulus, c_modulus) = (system.a.abs(), system.c.abs());
    let (mut x, mut x_modulus) = (system.b.clone(), system.b.abs());
    for step in 1..=n {
        // One step of the reduction: rotate the states so that the output is the last state alone, and hold
        // that state at zero.
        let (v, _) = row_compression(&r.c.transpose(), 0.0);
        let order: Vec<usize> = (1..r.a.nrows()).chain([0]).collect();
        let v = v.select_columns(&order);
        let last = r.a.nrows() - 1;
        let output = (&r.c * &v)[(0, last)];
        let a = v.transpose() * &r.a * &v;
        let b = v.transpose() * &r.b;
        r = Reduced {
            a: a.view((0, 0), (last, last)).into_owned(),
            b: b.rows(0, last).into_owned(),
            c: a.view((last, 0), (1, last)).into_owned(),
            d: b.rows(last, 1).into_owned(),
        };
        // x holds A^(step - 1) B over the product of the outputs, so that C x is the feed-through after this
        // step.
        x /= output;
        x_modulus /= output.abs();
        let markov = (&system.c * &x)[(0, 0)];
        let rounding = (2 * n * (step + 1)) as f64 * f64::EPSILON * (&c_modulus * &x_modulus)[(0, 0)];
        if markov.abs() > rounding {
            r.d[(0, 0)] = markov;
            return Some(r);
        }
        r.d[(0, 0)] = 0.0;
        if output.abs() <= 0.0 {
            return None;
        }
        x = &system.a * x;
        x_modulus = &a_modulus * x_modulus;
    }
    None
}

fn transpose(r: &Reduced) -> Reduced {
    Reduced { a: r.a.transpose(), b: r.c.transpose(), c: r.b.transpose(), d: r.d.transpose() }
}

/// Removes the infinite zeros visible in the rows of D, until D has full row rank.
fn reduce(mut r: Reduced, tolerance: f64) -> Reduced {
    loop {
        // Rows of D: U^T D = [D1; 0].
        let (u, sigma) = row_compression(&r.d, tolerance);
        let c = u.transpose() * &r.c;
        let d = u.transpose() * &r.d;
        let quiet = r.d.nrows() - sigma;
        let (c1, c2) = (c.rows(0, sigma).into_owned(), c.rows(sigma, quiet).into_owned());
        let d1 = d.rows(0, sigma).into_owned();
        if quiet == 0 {
            return Reduced { c: c1, d: d1, ..r };
        }
        // Columns of C2: C2 V = [0 S], from the row compression of its transpose, with the found directions
        // last.
        let (v, rho) = row_compression(&c2.transpose(), tolerance);
        let n = r.a.nrows();
        if rho == 0 {
            return Reduced { c: c1, d: d1, ..r };
        }
        let kept = n - rho;
        let mut order: Vec<usize> = (rho..n).collect();
        order.extend(0..rho);
        let v = v.select_columns(&order);
        let a = v.transpose() * &r.a * &v;
        let b = v.transpose() * &r.b;
        let c1 = c1 * &v;
        r = Reduced {
            a: a.view((0, 0), (kept, kept)).into_owned(),
            b: b.rows(0, kept).into_owned(),
            c: stack(&a.view((kept, 0), (rho, kept)).into_owned(), &c1.columns(0, kept).into_owned()),
            d: stack(&b.rows(kept, rho).into_owned(), &d1),
        };
    }
}

fn stack(top: &DMatrix<f64>, bottom: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(top.nrows() + bottom.nrows(), top.ncols());
    out.rows_mut(0, top.nrows()).copy_from(top);
    out.rows_mut(top.nrows(), bottom.nrows()).copy_from(bottom);
    out
}

/// An orthogonal U (square) with U^T M = [R; 0], R of full row rank, and that rank: Householder reflections
/// with column pivoting.
fn row_compression(m: &DMatrix<f64>, tolerance: f64) -> (DMatrix<f64>, usize) {
    let (rows, columns) = m.shape();
    let mut r = m.clone();
    let mut u = DMatrix::identity(rows, rows);
    for k in 0..rows.min(columns) {
        let below = |r: &DMatrix<f64>, j: usize| r.view((k, j), (rows - k, 1)).norm();
        let norms: Vec<f64> = (0..columns).map(|j| below(&r, j)).collect();
        let pivot = (0..columns).max_by(|&i, &j| norms[i].total_cmp(&norms[j]));
        let Some(pivot) = pivot.filter(|&j| norms[j] > tolerance) else { return (u, k) };
        // A column with one nonzero element is only exchanged, so that exact zeros stay exact.
        let mut w = r.view((k, pivot), (rows - k, 1)).into_owned();
        let sign = if w[0] < 0.0 { -1.0 } else { 1.0 };
        w[0] += sign * norms[pivot];
        let w_squared = w.norm_squared();
        let mut lower = r.rows_mut(k, rows - k);
        let update = &w * (w.transpose() * &lower) * (2.0 / w_squared);
        lower -= update;
        let mut right = u.columns_mut(k, rows - k);
        let update = (&right * &w) * w.transpose() * (2.0 / w_squared);
        right -= update;
    }
    (u, rows.min(columns))
}

/// Eigenvalues of the pencil [A B; C D] - z [I 0; 0 0], D invertible: as many as A has rows.
fn pencil_eigenvalues(r: &Reduced) -> Result<Vec<C64>, LtiError> {
    if r.d.is_empty() {
        return eigenvalues(&r.a);
    }
    let solved = r.d.clone().full_piv_lu().solve(&r.c).ok_or(LtiError::Degenerate)?;
    eigenvalues(&(&r.a - &r.b * solved))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn truth_square_plant_with_two_inputs() {
        // diag((s + 4) / (s + 1), (s - 5) / (s + 2)): zeros at -4 and 5.
        let system = StateSpace::new(
            dmatrix![-1.0, 0.0; 0.0, -2.0],
            DMatrix::identity(2, 2),
            dmatrix![3.0, 0.0; 0.0, -7.0],
            DMatrix::identity(2, 2),
        )
        .unwrap();
        let zeros = system.zeros().unwrap();
        assert!((zeros[0] + 4.0).norm() < 1e-14 && (zeros[1] - 5.0).norm() < 1e-14);
    }

    /// Simple zeros need no polish beyond rounding; a double one is off by the root of it.
    #[test]
    fn truth_unpolished_zeros_are_those_of_a_picture() {
        // (z - 0.5)^2 (z + 0.25) / z^3
        let system = StateSpace::new(
            dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; 0.0, 0.0, 0.0],
            dmatrix![0.0; 0.0; 1.0],
            dmatrix![0.0625, 0.0, -0.75],
            dmatrix![1.0],
        )
        .unwrap();
        let zeros = system.unpolished_zeros().unwrap();
        assert!((zeros[0] + 0.25).norm() < 1e-12, "{zeros:?}");
        assert!(zeros[1..].iter().all(|z| (z - 0.5).norm() < 1e-7), "{zeros:?}");
    }

    #[test]
    fn truth_two_sensors_have_no_common_zero() {
        let system = StateSpace::new(
            dmatrix![0.0, 1.0; -2.0, -3.0],
            dmatrix![0.0; 1.0],
            dmatrix![1.0, 0.0; 3.0, 1.0],
            dmatrix![0.0; 0.0],
        );
        assert_eq!(system.unwrap().zeros().unwrap(), Vec::new());
    }

    #[test]
    fn truth_no_path_is_degenerate() {
        let system = StateSpace::new(
            dmatrix![-1.0, 0.0; 0.0, -2.0],
            dmatrix![1.0; 0.0],
            dmatrix![0.0, 1.0],
            dmatrix![0.0],
        )
        .unwrap();
        assert_eq!(system.zeros(), Err(LtiError::Degenerate));
    }

    #[test]
    fn truth_chain_of_integrators_has_no_finite_zero() {
        let n = 9;
        let a =
            DMatrix::from_fn(
                n,
                n,
                |i, j| if j == i + 1 { 3e3 } else { -1e-2 * f64::from(u8::from(i == n - 1)) },
            );
        let b = DMatrix::from_fn(n, 1, |i, _| f64::from(u8::from(i == n - 1)));
        let c = DMatrix::from_fn(1, n, |_, j| f64::from(u8::from(j == 0)));
        let system = StateSpace::new(a, b, c, dmatrix![0.0]).unwrap();
        assert_eq!(system.zeros().unwrap(), Vec::new());
    }
}
