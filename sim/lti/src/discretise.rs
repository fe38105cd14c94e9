//! Exact discretisation: the samples of the result equal those of the continuous system, for an input that is
//! held between samples.
//!
//! Source: Astrom and Wittenmark, Computer-Controlled Systems (3rd ed.), sections 2.3 and 3.2 (delays).

use nalgebra::DMatrix;

use crate::error::{LtiError, require_not_negative, require_positive};
use crate::expm::expm_integrals;
use crate::state_space::{DiscreteStateSpace, StateSpace};

/// Tolerance of a delay that is a whole number of samples, as a share of the period: 0.003 s at 1 kHz is
/// three samples.
const WHOLE_SAMPLE: f64 = 1e-9;

impl StateSpace {
    /// The system behind a zero-order hold, sampled at the same instants. States keep their meaning.
    ///
    /// # Errors
    /// [`LtiError::OutOfRange`] unless the period is positive and finite.
    pub fn zero_order_hold(&self, period_s: f64) -> Result<DiscreteStateSpace, LtiError> {
        require_positive("sample time (s)", period_s)?;
        let e = expm_integrals(self.a(), self.b(), period_s)?;
        StateSpace::discrete(e.transition, e.step, self.c().clone(), self.d().clone(), period_s)
    }

    /// The system behind a zero-order hold whose changes arrive `delay_s` late, by any real number of
    /// seconds.
    ///
    /// The delay is split into whole samples and a remainder. The held inputs in transit are appended to the
    /// n states, newest first: `u[k-1], u[k-2], ...`, m each. From input to output, a delay of the sampled
    /// output equals one of the input. So the two delays of a loop may be added here.
    ///
    /// # Errors
    /// [`LtiError::OutOfRange`] unless the period is positive, the delay not negative, and both finite.
    pub fn zero_order_hold_delayed(
        &self,
        period_s: f64,
        delay_s: f64,
    ) -> Result<DiscreteStateSpace, LtiError> {
        require_positive("sample time (s)", period_s)?;
        require_not_negative("delay (s)", delay_s)?;
        let samples = delay_s / period_s;
        let nearest = samples.round();
        let (whole, remainder_s) = if (samples - nearest).abs() <= WHOLE_SAMPLE {
            (nearest as usize, 0.0)
        } else {
            (samples.floor() as usize, (samples - samples.floor()) * period_s)
        };
        let (n, m) = (self.states(), self.inputs());
        // u[k - whole] acts in the last (period - remainder) of each period, u[k - whole - 1] before it.
        let late = expm_integrals(self.a(), self.b(), period_s - remainder_s)?;
        let early = expm_integrals(self.a(), self.b(), remainder_s)?;
        let stored = whole + usize::from(remainder_s > 0.0);
        let order = n + stored * m;
        let mut a = DMatrix::zeros(order, order);
        let mut b = DMatrix::zeros(order, m);
        let mut c = DMatrix::zeros(self.outputs(), order);
        let mut d = DMatrix::zeros(self.outputs(), m);
        a.view_mut((0, 0), (n, n)).copy_from(&expm_integrals(self.a(), self.b(), period_s)?.transition);
        c.view_mut((0, 0), (self.outputs(), n)).copy_from(self.c());
        // Column of A (or B, for lag 0) that multiplies u[k - lag].
        let column_of = |lag: usize| n + (lag - 1) * m;
        if whole == 0 {
            b.view_mut((0, 0), (n, m)).copy_from(&late.step);
        } else {
            a.view_mut((0, column_of(whole)), (n, m)).copy_from(&late.step);
        }
        if remainder_s > 0.0 {
            a.view_mut((0, column_of(whole + 1)), (n, m)).copy_from(&(&late.transition * &early.step));
        }
        if stored == 0 {
            d.copy_from(self.d());
        } else {
            // At the sampling instant itself the newest input has not yet arrived.
            c.view_mut((0, column_of(stored)), (self.outputs(), m)).copy_from(self.d());
            b.view_mut((n, 0), (m, m)).fill_with_identity();
            for lag in 2..=stored {
                a.view_mut((column_of(lag), column_of(lag - 1)), (m, m)).fill_with_identity();
            }
        }
        StateSpace::discrete(a, b, c, d, period_s)
    }
}
