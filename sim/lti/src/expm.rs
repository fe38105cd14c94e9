//! Matrix exponential and its integrals.
//!
//! Scaling and squaring of a Taylor polynomial of the balanced matrix. A Taylor polynomial needs no linear
//! solve, so exact structure of A stays exact in exp(A). A row of zeros gives a row of the identity, bit for
//! bit, and a block triangle stays one. Sources: Moler and Van Loan, SIAM Review 45 (2003), method 3; Van
//! Loan, IEEE Trans. Automatic Control 23 (1978) for the integrals.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};

use crate::balance::balance;
use crate::error::{LtiError, require_finite, require_shape};

/// The 1-norm to which a matrix is scaled. Above one half, terms begin to cancel; below, squarings add up.
const SCALED_NORM: f64 = 0.5;
/// Largest number of Taylor terms: 0.5^40 / 40! is 1e-60.
const MAX_TERMS: usize = 40;
/// Largest matrix that is multiplied by plain loops.
const LARGEST_PLAIN: usize = 24;
/// A larger one too, if at most one in this many of its factors is not zero: rows of bodies have a few each.
const SPARSE: usize = 8;
/// Rows of a power that are computed side by side.
const ROWS: usize = 8;

/// exp(A) of a square matrix.
///
/// # Errors
/// [`LtiError::Shape`] or [`LtiError::NotFinite`].
///
/// # Example
/// ```
/// use nalgebra::DMatrix;
/// let quarter_turn = DMatrix::from_row_slice(2, 2, &[0.0, -1.0, 1.0, 0.0]) * std::f64::consts::FRAC_PI_2;
/// let e = feeler_lti::expm(&quarter_turn)?;
/// assert!((e[(1, 0)] - 1.0).abs() < 1e-15 && e[(0, 0)].abs() < 1e-15);
/// # Ok::<(), feeler_lti::LtiError>(())
/// ```
pub fn expm(a: &DMatrix<f64>) -> Result<DMatrix<f64>, LtiError> {
    require_shape("A", a, (a.nrows(), a.nrows()))?;
    require_finite("A", a)?;
    let balanced = balance(a);
    let norm = one_norm(&balanced.matrix);
    let squarings = if norm > SCALED_NORM { (norm / SCALED_NORM).log2().ceil() as i32 } else { 0 };
    let mut e = taylor(&(balanced.matrix * 2_f64.powi(-squarings)));
    let mut square = e.clone();
    for _ in 0..squarings {
        multiply(e.as_slice(), e.as_slice(), square.as_mut_slice(), a.nrows());
        std::mem::swap(&mut e, &mut square);
    }
    let scale = balanced.scale;
    for j in 0..e.ncols() {
        for i in 0..e.nrows() {
            e[(i, j)] *= scale[i] / scale[j];
        }
    }
    Ok(e)
}

fn one_norm(m: &DMatrix<f64>) -> f64 {
    m.column_iter().map(|column| column.iter().map(|v| v.abs()).sum()).fold(0.0, f64::max)
}

/// Taylor polynomial of exp, continued until no element of the sum changes. It has at least as many terms as
/// there are states, since the corner element of a chain of integrators appears only then.
fn taylor(a: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.nrows();
    if n > MAX_TERMS && !is_dense(a.as_slice(), n) { taylor_by_rows(a) } else { taylor_whole(a) }
}

fn taylor_whole(a: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.nrows();
    let size = n * n;
    // All terms in one block of memory.
    let mut terms = DMatrix::<f64>::identity(n, n).as_slice().to_vec();
    let mut sum_of_sizes = terms.clone();
    for k in 1..=MAX_TERMS.max(n) {
        terms.resize((k + 1) * size, 0.0);
        let (known, term) = terms.split_at_mut(k * size);
        multiply(&known[(k - 1) * size..], a.as_slice(), term, n);
        let (mut negligible, mut vanishes) = (true, true);
        for (t, s) in term.iter_mut().zip(&mut sum_of_sizes) {
            *t /= k as f64;
            negligible &= t.abs() <= 0.125 * f64::EPSILON * *s;
            vanishes &= *t == 0.0;
            *s += t.abs();
        }
        if vanishes || (negligible && k >= n) {
            terms.truncate(k * size);
            break;
        }
    }
    // Smallest terms first: the rounding of the sum is then that of its last addition.
    let mut sum = DMatrix::zeros(n, n);
    for term in terms[size..].rchunks_exact(size.max(1)) {
        sum.iter_mut().zip(term).for_each(|(sum, t)| *sum += t);
    }
    for i in 0..n {
        sum[(i, i)] += 1.0;
    }
    sum
}

/// The bits of [`taylor_whole`], for more than [`MAX_TERMS`] states with few factors in each column. A row of
/// a power depends on no other row, so the terms of a few rows at a time fit the cache.
fn taylor_by_rows(a: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.nrows();
    // Factors that are not zero, column by column.
    let (mut starts, mut factors) = (vec![0], Vec::new());
    for column in a.column_iter() {
        factors.extend(column.iter().copied().enumerate().filter(|(_, factor)| *factor != 0.0));
        starts.push(factors.len());
    }
    let mut sum = DMatrix::zeros(n, n);
    let mut terms: Vec<[f64; ROWS]> = Vec::new();
    for first in (0..n).step_by(ROWS) {
        let rows = ROWS.min(n - first);
        terms.clear();
        terms.resize(n, [0.0; ROWS]);
        for side in 0..rows {
            terms[first + side][side] = 1.0;
        }
        for k in 1..=n {
            terms.resize((k + 1) * n, [0.0; ROWS]);
            let (known, term) = terms.split_at_mut(k * n);
            let last = &known[(k - 1) * n..];
            let mut vanishes = true;
            for (entry, ends) in term.iter_mut().zip(starts.windows(2)) {
                for &(i, factor) in &factors[ends[0]..ends[1]] {
                    for (t, x) in entry.iter_mut().zip(&last[i]) {
                        *t += x * factor;
                    }
                }
                for t in entry {
                    *t /= k as f64;
                    vanishes &= *t == 0.0;
                }
            }
            if vanishes {
                terms.truncate(k * n);
                break;
            }
        }
        let mut total = vec![[0.0; ROWS]; n];
        for term in terms[n..].rchunks_exact(n) {
            for (total, entry) in total.iter_mut().zip(term) {
                for (sum, t) in total.iter_mut().zip(entry) {
                    *sum += t;
                }
            }
        }
        for (j, total) in total.iter().enumerate() {
            for (side, value) in total[..rows].iter().enumerate() {
                sum[(first + side, j)] = *value;
            }
        }
    }
    for i in 0..n {
        sum[(i, i)] += 1.0;
    }
    sum
}

/// Whether a square matrix of order `n` has many factors that are not zero.
fn is_dense(factors: &[f64], n: usize) -> bool {
    factors.iter().filter(|factor| **factor != 0.0).count() > n * n / SPARSE
}

/// `out = a b` of square matrices of order `n`, column by column. For small matrices and for few factors this
/// is faster than the packing of a general product.
fn multiply(a: &[f64], b: &[f64], out: &mut [f64], n: usize) {
    if n > LARGEST_PLAIN && is_dense(b, n) {
        let [a, b] = [a, b].map(|m| DMatrixView::from_slice(m, n, n));
        DMatrixViewMut::from_slice(out, n, n).gemm(1.0, &a, &b, 0.0);
        return;
    }
    for (column, factors) in out.chunks_exact_mut(n.max(1)).zip(b.chunks_exact(n.max(1))) {
        column.fill(0.0);
        for (a, &factor) in a.chunks_exact(n.max(1)).zip(factors) {
            // Zeros are frequent: speeds are separate states, and inputs are held.
            if factor != 0.0 {
                for (sum, a) in column.iter_mut().zip(a) {
                    *sum += a * factor;
                }
            }
        }
    }
}

/// exp(A t) and the two integrals with which inputs enter over a time t.
#[derive(Debug, Clone, PartialEq)]
pub struct ExponentialIntegrals {
    /// exp(A t), n x n.
    pub transition: DMatrix<f64>,
    /// Integral over s from 0 to t of exp(A s) B, n x m: the response to a constant unit input.
    pub step: DMatrix<f64>,
    /// Integral over s from 0 to t of exp(A (t - s)) B s, n x m: the response to a unit ramp.
    pub ramp: DMatrix<f64>,
}

/// The exponential of A t together with its integrals over a constant and a ramp input (Van Loan).
///
/// # Errors
/// [`LtiError::Shape`] or [`LtiError::NotFinite`].
pub fn expm_integrals(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    duration_s: f64,
) -> Result<ExponentialIntegrals, LtiError> {
    let (n, m) = (a.nrows(), b.ncols());
    require_shape("A", a, (n, n))?;
    require_shape("B", b, (n, m))?;
    require_finite("duration (s)", [&duration_s])?;
    let mut block = DMatrix::zeros(n + 2 * m, n + 2 * m);
    block.view_mut((0, 0), (n, n)).copy_from(&(a * duration_s));
    block.view_mut((0, n), (n, m)).copy_from(&(b * duration_s));
    // The ramp runs from 0 to 1 over the duration, so that the block does not contain the duration itself.
    // The scaling is undone below.
    for j in 0..m {
        block[(n + j, n + m + j)] = 1.0;
    }
    let e = expm(&block)?;
    Ok(ExponentialIntegrals {
        transition: e.view((0, 0), (n, n)).into_owned(),
        step: e.view((0, n), (n, m)).into_owned(),
        ramp: e.view((0, n + m), (n, m)) * duration_s,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some tens of roundings: each squaring doubles the relative error of its argument.
    const ROUNDING: f64 = 1e-14;

    /// exp of the companion matrix of an underdamped oscillator, by hand.
    fn oscillator(w: f64, zeta: f64, t: f64) -> DMatrix<f64> {
        let (sigma, wd) = (zeta * w, w * (1.0 - zeta * zeta).sqrt());
        let (s, c) = (wd * t).sin_cos();
        let decay = (-sigma * t).exp();
        DMatrix::from_row_slice(2, 2, &[c + sigma / wd * s, s / wd, -w * w / wd * s, c - sigma / wd * s])
            * decay
    }

    #[test]
    fn truth_oscillator() {
        for (w, zeta, t) in
            [(50.0, 0.1, 1e-3), (50.0, 0.1, 0.3), (3000.0, 0.02, 1e-3), (1e5, 0.5, 1e-6), (700.0, 0.01, 0.1)]
        {
            let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -w * w, -2.0 * zeta * w]);
            let (found, truth) = (expm(&(a * t)).unwrap(), oscillator(w, zeta, t));
            // Elements are compared in units in which position and speed have equal scale; the phase w t
            // itself is known to w t roundings.
            let scale = [[1.0, 1.0 / w], [w, 1.0]];
            for i in 0..2 {
                for j in 0..2 {
                    assert!((found[(i, j)] - truth[(i, j)]).abs() < ROUNDING * (1.0 + w * t) * scale[i][j]);
                }
            }
        }
    }

    #[test]
    fn truth_single_step_is_accurate_to_rounding() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -2500.0, -10.0]) * 1e-3;
        let relative =
            (expm(&a).unwrap() - oscillator(50.0, 0.1, 1e-3)).component_div(&oscillator(50.0, 0.1, 1e-3));
        assert!(relative.amax() < 1e-15, "relative error {:e}", relative.amax());
    }

    #[test]
    fn truth_zero_rows_stay_exact() {
        let a = DMatrix::from_row_slice(3, 3, &[-3e3, 1e9, 7.0, 0.0, 0.0, 0.0, 4e2, -1e3, -9e4]);
        let e = expm(&a).unwrap();
        assert_eq!((e[(1, 0)], e[(1, 1)], e[(1, 2)]), (0.0, 1.0, 0.0));
    }

    #[test]
    fn truth_chain_of_integrators_fills_its_corner() {
        for n in [8, 40] {
            let a = DMatrix::from_fn(n, n, |i, j| if j == i + 1 { 1e-3 } else { 0.0 });
            let corner = expm(&a).unwrap()[(0, n - 1)];
            let truth = (1..n).map(|k| 1e-3 / k as f64).product::<f64>();
            // Two roundings of each factor, in `corner` and in `truth`.
            assert!((corner - truth).abs() < 4.0 * n as f64 * f64::EPSILON * truth, "{n}: {corner} {truth}");
        }
    }

    /// A chain of masses on springs, and the same beside a state that nothing moves.
    #[test]
    fn prop_powers_by_rows_are_those_of_the_whole_to_the_bit() {
        for (bodies, idle) in [(21, 0), (30, 1), (44, 3)] {
            let n = 2 * bodies + idle;
            let chain = DMatrix::from_fn(n, n, |i, j| match (i / bodies, j / bodies) {
                (0, 1) if i + bodies == j => 0.3,
                (1, 0) if i - bodies == j => -0.07,
                (1, 0) if (i - bodies).abs_diff(j) == 1 => 0.03,
                (1, 1) if i == j => -1e-3,
                _ => 0.0,
            });
            let (quick, whole) = (taylor_by_rows(&chain), taylor_whole(&chain));
            let bits = |m: &DMatrix<f64>| m.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert!(!is_dense(chain.as_slice(), n) && bits(&quick) == bits(&whole), "{bodies}");
            assert!(quick[(0, bodies - 1)] > 0.0);
        }
    }

    #[test]
    fn truth_integrals_of_a_first_order_lag() {
        let (tau, t) = (0.02_f64, 0.003_f64);
        let one = |v| DMatrix::from_element(1, 1, v);
        let found = expm_integrals(&one(-1.0 / tau), &one(1.0 / tau), t).unwrap();
        let decay = (-t / tau).exp();
        assert!((found.transition[0] - decay).abs() < 1e-15);
        assert!((found.step[0] + (-t / tau).exp_m1()).abs() < 1e-15);
        // Ramp response t - tau (1 - e^{-t/tau}), which loses about two digits to cancellation here.
        assert!((found.ramp[0] - (t + tau * (-t / tau).exp_m1())).abs() < 1e-16);
    }

    #[test]
    fn truth_bad_input_is_refused() {
        assert!(matches!(expm(&DMatrix::zeros(2, 3)), Err(LtiError::Shape { .. })));
        assert!(matches!(expm(&DMatrix::from_element(1, 1, f64::NAN)), Err(LtiError::NotFinite { .. })));
    }
}
