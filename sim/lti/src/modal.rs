//! A system in the coordinates of its modes: a point of its response is a sum over the poles.

use nalgebra::DMatrix;

use crate::domain::C64;
use crate::vectors::eigenpairs;

/// Largest condition of the matrix of eigenvectors. Beyond it some modes are almost equal, such as those of a
/// delay line or of a body that nothing holds.
const MOST_PARALLEL: f64 = 1e7;
/// Roundings of a term of the sum, times the condition of its mode.
const ROUNDINGS: f64 = 16.0;
/// Largest error of a response, as a share of it. Modes that cancel to less are left to another method.
const TRUSTED: f64 = 1e-10;
/// A point this close to a pole, relative to the matrix, equals it up to rounding.
const AT_POLE: f64 = 16.0 * f64::EPSILON;

/// A system in modal coordinates.
#[derive(Debug, Clone)]
pub(crate) struct Modal {
    poles: Vec<C64>,
    /// Per mode: 1 over the cosine of the angle between its left and right eigenvector.
    conditions: Vec<f64>,
    /// Modes x inputs.
    b: DMatrix<C64>,
    /// Outputs x modes.
    c: DMatrix<C64>,
    closest: f64,
}

impl Modal {
    /// From balanced matrices; `None` if the modes are too alike.
    pub(crate) fn new(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Option<Self> {
        let n = a.nrows();
        let (poles, vectors): (Vec<C64>, Vec<_>) =
            eigenpairs(a)?.into_iter().map(|(pole, vector)| (pole, vector.normalize())).unzip();
        let right = DMatrix::from_fn(n, n, |i, j| vectors[j][i]);
        let left = right.clone().try_inverse()?;
        let condition = right.norm() * left.norm();
        if !condition.is_finite() || condition > MOST_PARALLEL * n as f64 {
            return None;
        }
        let complex = |m: &DMatrix<f64>| m.map(|v| C64::new(v, 0.0));
        let conditions = (0..n).map(|i| left.row(i).norm() * right.column(i).norm()).collect();
        Some(Self {
            poles,
            conditions,
            b: left * complex(b),
            c: complex(c) * right,
            closest: AT_POLE * a.norm(),
        })
    }

    /// Gives C (p I - A)^-1 B and, on request, C (p I - A)^-2 B, or `None` at a pole, or if the sum cancels
    /// so far that its rounding shows.
    pub(crate) fn at(&self, point: C64, with_square: bool) -> Option<[DMatrix<C64>; 2]> {
        let inverses: Vec<C64> = self.poles.iter().map(|pole| (point - pole).inv()).collect();
        let is_near = |inverse: &C64| inverse.norm() * self.closest >= 1.0 || !inverse.is_finite();
        if inverses.iter().any(is_near) {
            return None;
        }
        let (outputs, inputs) = (self.c.nrows(), self.b.ncols());
        let mut found = [DMatrix::zeros(outputs, inputs), DMatrix::zeros(outputs, inputs)];
        for i in 0..outputs {
            for j in 0..inputs {
                let (mut sum, mut square, mut rounding) = (C64::default(), C64::default(), 0.0);
                for (k, inverse) in inverses.iter().enumerate() {
                    let term = self.c[(i, k)] * self.b[(k, j)] * inverse;
                    sum += term;
                    rounding += self.conditions[k] * (term.re.abs() + term.im.abs());
                    if with_square {
                        square += term * inverse;
                    }
                }
                if ROUNDINGS * f64::EPSILON * rounding > TRUSTED * sum.norm() {
                    return None;
                }
                (found[0][(i, j)], found[1][(i, j)]) = (sum, square);
            }
        }
        Some(found)
    }
}
