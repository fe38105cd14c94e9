//! Eigenvalues and eigenvectors of real matrices, balanced first, and poles.

use nalgebra::{DMatrix, DVector};

use crate::balance::{Balanced, balance};
use crate::domain::{C64, TimeDomain};
use crate::error::{LtiError, require_finite, require_shape};
use crate::francis::eigenvalues_by_francis;
use crate::state_space::StateSpace;
use crate::vectors::eigenpairs;

/// Eigenvalues of a real square matrix, by rising modulus; conjugate pairs are exact and adjacent, the
/// negative imaginary part first.
///
/// # Errors
/// [`LtiError::Shape`], [`LtiError::NotFinite`] or [`LtiError::EigenvaluesNotConverged`].
pub fn eigenvalues(a: &DMatrix<f64>) -> Result<Vec<C64>, LtiError> {
    eigenvalues_of_balanced(&checked_balance(a)?)
}

/// [`eigenvalues`] of a matrix that has been balanced already.
pub(crate) fn eigenvalues_of_balanced(balanced: &Balanced) -> Result<Vec<C64>, LtiError> {
    let order = balanced.matrix.nrows();
    let mut values =
        eigenvalues_by_francis(&balanced.matrix).ok_or(LtiError::EigenvaluesNotConverged { order })?;
    sort_by_modulus(&mut values);
    Ok(values)
}

/// Eigenvalues with their eigenvectors.
#[derive(Debug, Clone, PartialEq)]
pub struct Eigen {
    /// Eigenvalues, ordered as by [`eigenvalues`].
    pub values: Vec<C64>,
    /// Right eigenvectors, one for each eigenvalue, of unit 2-norm.
    pub vectors: Vec<DVector<C64>>,
}

/// Eigenvalues and right eigenvectors of a real square matrix.
///
/// # Errors
/// [`LtiError::Shape`], [`LtiError::NotFinite`] or [`LtiError::EigenvaluesNotConverged`].
pub fn eigen(a: &DMatrix<f64>) -> Result<Eigen, LtiError> {
    let balanced = checked_balance(a)?;
    let mut found =
        eigenpairs(&balanced.matrix).ok_or(LtiError::EigenvaluesNotConverged { order: a.nrows() })?;
    found.sort_by(|(p, _), (q, _)| compare_modulus(p, q));
    let unscaled = |v: DVector<C64>| DVector::from_fn(v.len(), |i, _| v[i] * balanced.scale[i]).normalize();
    let (values, vectors) = found.into_iter().map(|(value, v)| (value, unscaled(v))).unzip();
    Ok(Eigen { values, vectors })
}

/// A square, finite matrix, balanced.
pub(crate) fn checked_balance(a: &DMatrix<f64>) -> Result<Balanced, LtiError> {
    require_shape("A", a, (a.nrows(), a.nrows()))?;
    require_finite("A", a)?;
    Ok(balance(a))
}

fn compare_modulus(a: &C64, b: &C64) -> std::cmp::Ordering {
    a.norm().total_cmp(&b.norm()).then(a.re.total_cmp(&b.re)).then(a.im.total_cmp(&b.im))
}

pub(crate) fn sort_by_modulus(values: &mut [C64]) {
    values.sort_by(compare_modulus);
}

impl<T: TimeDomain> StateSpace<T> {
    /// Poles (s plane in rad/s, or z plane), by rising modulus.
    ///
    /// # Errors
    /// [`LtiError::EigenvaluesNotConverged`].
    pub fn poles(&self) -> Result<Vec<C64>, LtiError> {
        eigenvalues(self.a())
    }

    /// Largest growth rate of any free motion, 1/s; negative for a stable system, -infinity without states.
    ///
    /// # Errors
    /// [`LtiError::EigenvaluesNotConverged`].
    pub fn growth_per_s(&self) -> Result<f64, LtiError> {
        Ok(self.poles()?.into_iter().map(|p| self.domain().growth_per_s(p)).fold(f64::NEG_INFINITY, f64::max))
    }

    /// Whether every free motion decays.
    ///
    /// # Errors
    /// [`LtiError::EigenvaluesNotConverged`].
    pub fn is_stable(&self) -> Result<bool, LtiError> {
        Ok(self.growth_per_s()? < 0.0)
    }
}

/// Frequencies |s| / 2 pi (Hz) of poles or zeros, rising, conjugate pairs once.
pub fn frequencies_hz<T: TimeDomain>(domain: T, points: &[C64]) -> Vec<f64> {
    let mut frequencies: Vec<f64> =
        points.iter().filter(|p| p.im >= 0.0).map(|&p| domain.frequency_hz(p)).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies
}

/// Damping ratio -Re s / |s| of a pole, in [-1, 1]. It is 1 for a pole at the origin of the z plane, 0 for
/// one at s = 0.
pub fn damping_ratio<T: TimeDomain>(domain: T, pole: C64) -> f64 {
    let s = domain.s_of_point(pole);
    if s.re == f64::NEG_INFINITY {
        1.0
    } else if s.norm() > 0.0 {
        -s.re / s.norm()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Continuous;

    #[test]
    fn truth_badly_scaled_oscillator() {
        let (w, zeta) = (1e5_f64, 1e-3);
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -w * w, -2.0 * zeta * w]);
        let truth = C64::new(-zeta * w, w * (1.0 - zeta * zeta).sqrt());
        // A dozen roundings of |s|; without balancing the error is of order eps w^2.
        assert!((eigenvalues(&a).unwrap()[1] - truth).norm() < 1e-14 * w);
        assert!((damping_ratio(Continuous, truth) - zeta).abs() < 1e-15);
        assert_eq!(frequencies_hz(Continuous, &eigenvalues(&a).unwrap()).len(), 1);
    }

    #[test]
    fn truth_vectors_satisfy_their_equation() {
        let a =
            DMatrix::from_fn(6, 6, |i, j| ((3 * i + 5 * j) % 7) as f64 * 10_f64.powf(i as f64 - j as f64));
        let found = eigen(&a).unwrap();
        let complex = a.map(|v| C64::new(v, 0.0));
        for (value, vector) in found.values.iter().zip(&found.vectors) {
            let residual = &complex * vector - vector * *value;
            assert!(residual.norm() < 1e-13 * complex.norm());
        }
    }

    #[test]
    fn truth_no_states_no_poles() {
        assert_eq!(eigenvalues(&DMatrix::zeros(0, 0)).unwrap(), Vec::new());
    }
}
