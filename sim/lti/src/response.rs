//! Frequency response and other values of a transfer function, by one LU solve for each point.

use nalgebra::DMatrix;

use crate::balance::balance;
use crate::domain::{C64, TimeDomain};
use crate::error::LtiError;
use crate::state_space::StateSpace;

/// A system prepared (balanced) for the evaluation of C (p I - A)^-1 B + D at many points p.
#[derive(Debug, Clone)]
pub struct TransferEvaluator {
    a: DMatrix<C64>,
    b: DMatrix<C64>,
    c: DMatrix<C64>,
    d: DMatrix<C64>,
}

impl TransferEvaluator {
    /// Prepares a system.
    pub fn new<T: TimeDomain>(system: &StateSpace<T>) -> Self {
        let complex = |m: &DMatrix<f64>| m.map(|v| C64::new(v, 0.0));
        let balanced = balance(system.a());
        let mut b = complex(system.b());
        let mut c = complex(system.c());
        for (i, &scale) in balanced.scale.iter().enumerate() {
            b.row_mut(i).scale_mut(1.0 / scale);
            c.column_mut(i).scale_mut(scale);
        }
        Self { a: complex(&balanced.matrix), b, c, d: complex(system.d()) }
    }

    /// The transfer matrix (outputs x inputs) at a point of the s or z plane.
    ///
    /// # Errors
    /// [`LtiError::AtPole`].
    pub fn at(&self, point: C64) -> Result<DMatrix<C64>, LtiError> {
        Ok(&self.c * self.solve(point, self.b.clone())? + &self.d)
    }

    /// The transfer matrix and its derivative with respect to the point, -C (p I - A)^-2 B.
    ///
    /// # Errors
    /// [`LtiError::AtPole`].
    pub fn with_derivative(&self, point: C64) -> Result<(DMatrix<C64>, DMatrix<C64>), LtiError> {
        let x = self.solve(point, self.b.clone())?;
        let value = &self.c * &x + &self.d;
        Ok((value, -(&self.c * self.solve(point, x)?)))
    }

    fn solve(&self, point: C64, mut right: DMatrix<C64>) -> Result<DMatrix<C64>, LtiError> {
        let mut resolvent = -self.a.clone();
        for i in 0..resolvent.nrows() {
            resolvent[(i, i)] += point;
        }
        let solved = resolvent.nrows() == 0 || resolvent.lu().solve_mut(&mut right);
        if solved && right.iter().all(|v| v.is_finite()) {
            Ok(right)
        } else {
            Err(LtiError::AtPole { re: point.re, im: point.im })
        }
    }
}

impl<T: TimeDomain> StateSpace<T> {
    /// The transfer matrix (outputs x inputs) at a point of the s or z plane. For many points use a
    /// [`TransferEvaluator`].
    ///
    /// # Errors
    /// [`LtiError::AtPole`].
    pub fn at(&self, point: C64) -> Result<DMatrix<C64>, LtiError> {
        TransferEvaluator::new(self).at(point)
    }

    /// Frequency response at each of the frequencies (Hz): a matrix (outputs x inputs) each.
    ///
    /// # Errors
    /// [`LtiError::AtPole`] where a pole lies on the stability boundary at one of the frequencies.
    ///
    /// # Example
    /// ```
    /// use feeler_lti::StateSpace;
    /// use nalgebra::dmatrix;
    /// let lag = StateSpace::new(dmatrix![-10.0], dmatrix![10.0], dmatrix![1.0], dmatrix![0.0])?;
    /// let corner = lag.frequency_response(&[10.0 / std::f64::consts::TAU])?;
    /// assert!((corner[0][0].norm() - 0.5_f64.sqrt()).abs() < 1e-15);
    /// # Ok::<(), feeler_lti::LtiError>(())
    /// ```
    pub fn frequency_response(&self, frequencies_hz: &[f64]) -> Result<Vec<DMatrix<C64>>, LtiError> {
        let evaluator = TransferEvaluator::new(self);
        frequencies_hz
            .iter()
            .map(|f| evaluator.at(self.domain().boundary_point(std::f64::consts::TAU * f)))
            .collect()
    }

    /// Frequency response of the system followed by a delay, with exp(-s tau) exact: a matrix (outputs x
    /// inputs) for each frequency (Hz).
    ///
    /// # Errors
    /// [`LtiError::AtPole`] as [`StateSpace::frequency_response`].
    pub fn delayed_frequency_response(
        &self,
        frequencies_hz: &[f64],
        delay_s: f64,
    ) -> Result<Vec<DMatrix<C64>>, LtiError> {
        let mut response = self.frequency_response(frequencies_hz)?;
        for (value, f) in response.iter_mut().zip(frequencies_hz) {
            *value *= C64::cis(-std::f64::consts::TAU * f * delay_s);
        }
        Ok(response)
    }

    /// Gain at zero frequency (outputs x inputs).
    ///
    /// # Errors
    /// [`LtiError::AtPole`] where the system integrates.
    pub fn dc_gain(&self) -> Result<DMatrix<f64>, LtiError> {
        Ok(self.at(self.domain().point_of_s(C64::new(0.0, 0.0)))?.map(|v| v.re))
    }
}

/// Phase (rad) of each element of a sequence, continued without jumps of more than half a turn; the first
/// lies in (-pi, pi].
pub fn unwrapped_phase_rad(values: &[C64]) -> Vec<f64> {
    let mut phase: Vec<f64> = values.iter().map(|v| v.arg()).collect();
    for i in 1..phase.len() {
        let turns = ((phase[i] - phase[i - 1]) / std::f64::consts::TAU).round();
        phase[i] -= turns * std::f64::consts::TAU;
    }
    phase
}
