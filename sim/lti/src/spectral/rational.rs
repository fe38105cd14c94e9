//! Poles of a machine from its measured frequency responses: one common set of poles.
//!
//! Source: Gustavsen and Semlyen, "Rational approximation of frequency domain responses by vector fitting",
//! IEEE Trans. Power Delivery 14 (1999). Each response is weighted by its inverse modulus. A constant and a
//! linear term represent modes beyond the band.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use crate::domain::C64;
use crate::eigen::eigenvalues;
use crate::error::{LtiError, require_not_negative};

/// Damping ratio at the start of the search.
const START_DAMPING: f64 = 0.01;
/// Number of relocations; poles of noise-free responses converge after about five.
const RELOCATIONS: usize = 20;

/// One real pole, or a pair.
#[derive(Clone, Copy)]
enum Root {
    Real(f64),
    Pair(C64),
}

impl Root {
    fn width(self) -> usize {
        match self {
            Self::Real(_) => 1,
            Self::Pair(_) => 2,
        }
    }
}

/// Poles (rad/s, those with positive imaginary part) common to several responses that share their frequencies
/// (Hz). `pairs` pairs are sought from evenly spaced ones over the band.
///
/// # Errors
/// [`LtiError::RecordLengths`] if a response has another length than the frequencies.
/// [`LtiError::RecordTooShort`] for fewer frequencies than unknowns; [`LtiError::OutOfRange`] for a negative
/// frequency. [`LtiError::Degenerate`] if the responses do not determine the poles.
///
/// # Example
/// ```
/// use feeler_lti::{C64, spectral::common_poles};
/// let mode = C64::new(-3.0, 200.0);
/// let frequencies_hz: Vec<f64> = (0..200).map(|i| 10.0 + 0.2 * f64::from(i)).collect();
/// let response = frequencies_hz.iter().map(|f| {
///     let s = C64::new(0.0, std::f64::consts::TAU * f);
///     ((s - mode) * (s - mode.conj())).inv()
/// });
/// let found = common_poles(&frequencies_hz, &[response.collect()], 1)?;
/// assert!((found[0] - mode).norm() < 1e-6);
/// # Ok::<(), feeler_lti::LtiError>(())
/// ```
pub fn common_poles(
    frequencies_hz: &[f64],
    responses: &[Vec<C64>],
    pairs: usize,
) -> Result<Vec<C64>, LtiError> {
    for response in responses {
        if response.len() != frequencies_hz.len() {
            return Err(LtiError::RecordLengths { left: frequencies_hz.len(), right: response.len() });
        }
    }
    let unknowns = 2 * pairs + (2 * pairs + 2) * responses.len();
    if 2 * frequencies_hz.len() * responses.len() < unknowns {
        return Err(LtiError::RecordTooShort {
            needed: unknowns,
            found: 2 * frequencies_hz.len() * responses.len(),
        });
    }
    let mut top: f64 = 0.0;
    for &f in frequencies_hz {
        require_not_negative("frequency", f)?;
        top = top.max(TAU * f);
    }
    // In units of the highest frequency all terms have comparable size.
    let s: Vec<C64> = frequencies_hz.iter().map(|f| C64::new(0.0, TAU * f / top)).collect();
    let start = |i: usize| {
        let w = (i as f64 + 0.5) / pairs as f64;
        Root::Pair(C64::new(-START_DAMPING * w, w))
    };
    let mut roots: Vec<Root> = (0..pairs).map(start).collect();
    for _ in 0..RELOCATIONS {
        roots = relocate(&roots, &s, responses)?;
    }
    let mut found: Vec<C64> =
        roots.iter().filter_map(|root| if let Root::Pair(p) = root { Some(p * top) } else { None }).collect();
    found.sort_by(|a, b| a.im.total_cmp(&b.im));
    Ok(found)
}

/// Partial fractions of the roots at a point, combined so that real coefficients give real responses.
fn fractions(roots: &[Root], s: C64) -> Vec<C64> {
    let mut all = Vec::new();
    for root in roots {
        match *root {
            Root::Real(p) => all.push((s - p).inv()),
            Root::Pair(p) => {
                let (a, b) = ((s - p).inv(), (s - p.conj()).inv());
                all.push(a + b);
                all.push(C64::new(0.0, 1.0) * (a - b));
            }
        }
    }
    all
}

/// One relocation: the zeros of the common weight `sigma` become the poles.
fn relocate(roots: &[Root], s: &[C64], responses: &[Vec<C64>]) -> Result<Vec<Root>, LtiError> {
    let order: usize = roots.iter().map(|root| root.width()).sum();
    let rows = 2 * s.len();
    // The equations of the weight, with each response's own coefficients eliminated.
    let mut normal = DMatrix::zeros(order, order);
    let mut right = DVector::zeros(order);
    for response in responses {
        let mut own = DMatrix::zeros(rows, order + 2);
        let mut common = DMatrix::zeros(rows, order);
        let mut target = DVector::zeros(rows);
        for (i, (&s, &g)) in s.iter().zip(response).enumerate() {
            let weight = 1.0 / g.norm().max(f64::MIN_POSITIVE);
            let terms = fractions(roots, s);
            let put = |m: &mut DMatrix<f64>, j: usize, v: C64| {
                m[(2 * i, j)] = v.re * weight;
                m[(2 * i + 1, j)] = v.im * weight;
            };
            for (j, &term) in terms.iter().enumerate() {
                put(&mut own, j, term);
                put(&mut common, j, -g * term);
            }
            put(&mut own, order, C64::new(1.0, 0.0));
            put(&mut own, order + 1, s);
            target[2 * i] = g.re * weight;
            target[2 * i + 1] = g.im * weight;
        }
        let q = own.qr().q();
        let left = &common - &q * (q.transpose() * &common);
        let rest = &target - &q * (q.transpose() * &target);
        normal += left.transpose() * &left;
        right += left.transpose() * &rest;
    }
    let weights = solve(&normal, &right)?;
    let mut a = DMatrix::zeros(order, order);
    let mut b = DVector::zeros(order);
    let mut next = 0;
    for root in roots {
        match *root {
            Root::Real(p) => {
                a[(next, next)] = p;
                b[next] = 1.0;
            }
            Root::Pair(p) => {
                a[(next, next)] = p.re;
                a[(next + 1, next + 1)] = p.re;
                a[(next, next + 1)] = p.im;
                a[(next + 1, next)] = -p.im;
                b[next] = 2.0;
            }
        }
        next += root.width();
    }
    let zeros = eigenvalues(&(a - b * weights.transpose()))?;
    // A measured machine is stable: poles of the right half plane are mirrored.
    let stable = zeros.into_iter().filter(|z| z.im >= 0.0).map(|z| C64::new(-z.re.abs(), z.im));
    Ok(stable.map(|z| if z.im > 0.0 { Root::Pair(z) } else { Root::Real(z.re) }).collect())
}

/// Least squares from normal equations with scaled unknowns.
fn solve(normal: &DMatrix<f64>, right: &DVector<f64>) -> Result<DVector<f64>, LtiError> {
    let n = right.len();
    let size = DVector::from_fn(n, |i, _| 1.0 / normal[(i, i)].sqrt().max(f64::MIN_POSITIVE));
    let scaled = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] * size[i] * size[j]);
    let solution = scaled.svd(true, true).solve(&right.component_mul(&size), 1e-14);
    solution.map(|x| x.component_mul(&size)).map_err(|_| LtiError::Degenerate)
}
