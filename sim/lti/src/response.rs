//! Frequency response and other values of a transfer function, with one solve for each point.

use nalgebra::DMatrix;
use nalgebra::linalg::Hessenberg;

use crate::balance::balance;
use crate::domain::{C64, TimeDomain};
use crate::error::LtiError;
use crate::modal::Modal;
use crate::state_space::StateSpace;

/// From this number of states onwards, A is first reduced to Hessenberg form. A point then costs the square
/// of the number of states instead of its cube (A. Laub, IEEE Trans. Automatic Control 26, 1981).
const MANY_STATES: usize = 24;

/// A system prepared (balanced) for the evaluation of C (p I - A)^-1 B + D at many points p.
#[derive(Debug, Clone)]
pub struct TransferEvaluator {
    /// A, or its transpose in Hessenberg form.
    a: DMatrix<C64>,
    /// Whether A is zero below its first subdiagonal.
    is_hessenberg: bool,
    /// The same system in its modes, if these are distinct.
    modal: Option<Modal>,
    b: DMatrix<C64>,
    c: DMatrix<C64>,
    d: DMatrix<C64>,
}

impl TransferEvaluator {
    /// Prepares a system.
    pub fn new<T: TimeDomain>(system: &StateSpace<T>) -> Self {
        let balanced = balance(system.a());
        let (a, mut b, mut c) = (balanced.matrix, system.b().clone(), system.c().clone());
        for (i, &scale) in balanced.scale.iter().enumerate() {
            b.row_mut(i).scale_mut(1.0 / scale);
            c.column_mut(i).scale_mut(scale);
        }
        Self::of_balanced(a, b, c, system.d())
    }

    /// Prepares balanced matrices.
    pub(crate) fn of_balanced(
        mut a: DMatrix<f64>,
        mut b: DMatrix<f64>,
        mut c: DMatrix<f64>,
        d: &DMatrix<f64>,
    ) -> Self {
        let complex = |m: &DMatrix<f64>| m.map(|v| C64::new(v, 0.0));
        let is_hessenberg = a.nrows() >= MANY_STATES;
        if is_hessenberg {
            let (q, h) = Hessenberg::new(a).unpack();
            (a, b, c) = (h.transpose(), q.tr_mul(&b), c * q);
        }
        let (a, b, c, d) = (complex(&a), complex(&b), complex(&c), complex(d));
        Self { a, is_hessenberg, modal: None, b, c, d }
    }

    /// This evaluator, prepared further if the system has many states. The cost of a point is then
    /// proportional to the number of states. The preparation costs as much as some hundred points.
    #[must_use]
    pub fn for_many_points(self) -> Self {
        let real = |m: &DMatrix<C64>| m.map(|v| v.re);
        let modes = || Modal::new(&real(&self.a).transpose(), &real(&self.b), &real(&self.c));
        let modal = self.is_hessenberg.then(modes).flatten();
        Self { modal, ..self }
    }

    /// The transfer matrix (outputs x inputs) at a point of the s or z plane.
    ///
    /// # Errors
    /// [`LtiError::AtPole`].
    pub fn at(&self, point: C64) -> Result<DMatrix<C64>, LtiError> {
        if let Some([value, _]) = self.modal.as_ref().and_then(|modal| modal.at(point, false)) {
            return Ok(value + &self.d);
        }
        Ok(&self.c * self.solve(point, self.b.clone())? + &self.d)
    }

    /// The transfer matrix and its derivative with respect to the point, -C (p I - A)^-2 B.
    ///
    /// # Errors
    /// [`LtiError::AtPole`].
    pub fn with_derivative(&self, point: C64) -> Result<(DMatrix<C64>, DMatrix<C64>), LtiError> {
        if let Some([value, square]) = self.modal.as_ref().and_then(|modal| modal.at(point, true)) {
            return Ok((value + &self.d, -square));
        }
        let x = self.solve(point, self.b.clone())?;
        let value = &self.c * &x + &self.d;
        Ok((value, -(&self.c * self.solve(point, x)?)))
    }

    fn solve(&self, point: C64, mut right: DMatrix<C64>) -> Result<DMatrix<C64>, LtiError> {
        let mut resolvent = -&self.a;
        for i in 0..resolvent.nrows() {
            resolvent[(i, i)] += point;
        }
        let solved = if self.is_hessenberg {
            solve_hessenberg(resolvent, &mut right);
            true
        } else {
            resolvent.nrows() == 0 || resolvent.lu().solve_mut(&mut right)
        };
        if solved && right.iter().all(|v| v.is_finite()) {
            Ok(right)
        } else {
            Err(LtiError::AtPole { re: point.re, im: point.im })
        }
    }
}

/// Solves H x = b in place, for H zero below its first subdiagonal, by elimination with exchange of
/// neighbouring rows. A row of H is a column of `rows`, so that it lies together. A singular H gives a
/// solution that is not finite.
fn solve_hessenberg(mut rows: DMatrix<C64>, b: &mut DMatrix<C64>) {
    let n = rows.nrows();
    for k in 0..n.saturating_sub(1) {
        let (upper, lower) = rows.as_mut_slice()[k * n..(k + 2) * n].split_at_mut(n);
        let (upper, lower) = (&mut upper[k..], &mut lower[k..]);
        if lower[0].norm_sqr() > upper[0].norm_sqr() {
            upper.swap_with_slice(lower);
            b.swap_rows(k, k + 1);
        }
        if lower[0] == C64::new(0.0, 0.0) {
            continue;
        }
        let factor = lower[0] / upper[0];
        for (below, above) in lower[1..].iter_mut().zip(&upper[1..]) {
            *below -= factor * above;
        }
        for j in 0..b.ncols() {
            let above = b[(k, j)];
            b[(k + 1, j)] -= factor * above;
        }
    }
    for mut x in b.column_iter_mut() {
        for k in (0..n).rev() {
            x[k] /= rows[(k, k)];
            let value = x[k];
            for i in 0..k {
                x[i] -= rows[(k, i)] * value;
            }
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
        let evaluator = TransferEvaluator::new(self).for_many_points();
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
}

/// Phase (rad) of each element of a sequence, continued without jumps of more than half a turn; the first is
/// in (-pi, pi].
pub fn unwrapped_phase_rad(values: &[C64]) -> Vec<f64> {
    let mut phase: Vec<f64> = values.iter().map(|v| v.arg()).collect();
    for i in 1..phase.len() {
        let turns = ((phase[i] - phase[i - 1]) / std::f64::consts::TAU).round();
        phase[i] -= turns * std::f64::consts::TAU;
    }
    phase
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Continuous;

    /// A chain of equal masses and springs, driven at one end and measured at the other.
    fn chain(bodies: usize) -> StateSpace<Continuous> {
        let (k, c) = (1e5, 10.0);
        let n = 2 * bodies;
        let mut a = DMatrix::zeros(n, n);
        for i in 0..bodies {
            a[(i, bodies + i)] = 1.0;
            for (j, sign) in [(Some(i), -2.0), (i.checked_sub(1), 1.0), (Some(i + 1), 1.0)] {
                let Some(j) = j.filter(|j| *j < bodies) else { continue };
                a[(bodies + i, j)] = sign * k;
                a[(bodies + i, bodies + j)] = sign * c;
            }
        }
        let mut b = DMatrix::zeros(n, 1);
        b[(bodies, 0)] = 1.0;
        let mut output = DMatrix::zeros(1, n);
        output[(0, bodies - 1)] = k;
        StateSpace::new(a, b, output, DMatrix::zeros(1, 1)).unwrap()
    }

    /// A chain between walls on springs. With `2 cos t = 2 + s^2 / (k + c s)` (masses of 1 kg) the transfer
    /// from the first force to the last position is `sin t / (sin((n + 1) t) (k + c s))`.
    #[test]
    fn truth_a_long_chain_answers_as_its_closed_form() {
        for bodies in [4, 12, 40, 90] {
            let evaluator = TransferEvaluator::new(&chain(bodies)).for_many_points();
            assert_eq!(evaluator.is_hessenberg, 2 * bodies >= MANY_STATES);
            // Poles are dense at the upper edge of the band, 632 rad/s; rounding of A appears a million times
            // larger there.
            for w in [0.1, 3.0, 20.0, 150.0, 500.0] {
                let s = C64::new(0.0, w);
                let spring = s * 10.0 + 1e5;
                let t = (s * s / spring / 2.0 + 1.0).acos();
                let truth = t.sin() / ((t * (bodies + 1) as f64).sin() * spring) * 1e5;
                let found = evaluator.at(s).unwrap()[(0, 0)];
                // Rounding of A is amplified by the sharpest mode, with damping of at least 1e-4 of its
                // frequency.
                assert!((found - truth).norm() <= 1e-9 * truth.norm(), "{bodies} {w}: {found} {truth}");
            }
        }
    }

    /// Elimination errs by rounding of A, amplified as in the test above. The sum over modes also errs by
    /// their condition.
    #[test]
    fn truth_the_sum_over_modes_is_the_response_by_elimination() {
        for bodies in [12, 40] {
            let quick = TransferEvaluator::new(&chain(bodies)).for_many_points();
            assert!(quick.modal.is_some());
            let plain = TransferEvaluator { modal: None, ..quick.clone() };
            for w in [0.1, 20.0, 150.0, 500.0, 650.0, 3000.0] {
                let s = C64::new(0.0, w);
                let (a, b) = (quick.with_derivative(s).unwrap(), plain.with_derivative(s).unwrap());
                for (a, b) in [(a.0[(0, 0)], b.0[(0, 0)]), (a.1[(0, 0)], b.1[(0, 0)])] {
                    assert!((a - b).norm() <= 1e-8 * b.norm(), "{bodies} {w}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn truth_the_derivative_is_that_of_the_values() {
        let evaluator = TransferEvaluator::new(&chain(40));
        let (s, step) = (C64::new(-1.0, 77.0), 1e-3);
        let (_, slope) = evaluator.with_derivative(s).unwrap();
        let around = [s + step, s - step].map(|at| evaluator.at(at).unwrap()[(0, 0)]);
        let difference = (around[0] - around[1]) / (2.0 * step);
        // A central difference errs by the square of its step over the distance to the next pole, 1/s.
        assert!((slope[(0, 0)] - difference).norm() < 1e-5 * difference.norm());
    }

    #[test]
    fn truth_a_pole_has_no_value() {
        let n = MANY_STATES;
        let a = DMatrix::from_fn(n, n, |i, j| if i == j { -(i as f64) } else { 0.0 });
        let one =
            StateSpace::new(a, DMatrix::repeat(n, 1, 1.0), DMatrix::repeat(1, n, 1.0), DMatrix::zeros(1, 1));
        assert!(matches!(one.unwrap().at(C64::new(-3.0, 0.0)), Err(LtiError::AtPole { .. })));
    }
}
