//! Zero-pole-gain form of a single-input single-output system.

use crate::domain::{C64, TimeDomain};
use crate::error::LtiError;
use crate::response::TransferEvaluator;
use crate::state_space::StateSpace;

/// If poles outnumber zeros by more than this, the response beyond all of them is rounding.
const LARGE_EXCESS: usize = 8;

/// H(p) = `leading_coefficient` * product of (p - zero) / product of (p - pole).
#[derive(Debug, Clone, PartialEq)]
pub struct ZeroPoleGain {
    /// Zeros, by rising modulus.
    pub zeros: Vec<C64>,
    /// Poles, by rising modulus.
    pub poles: Vec<C64>,
    /// Ratio of the leading coefficients of numerator and denominator.
    pub leading_coefficient: f64,
}

impl ZeroPoleGain {
    /// Value at a point of the s or z plane.
    pub fn at(&self, point: C64) -> C64 {
        // Factors alternate between both lists, so that neither product overflows.
        let mut value = C64::new(self.leading_coefficient, 0.0);
        for i in 0..self.poles.len().max(self.zeros.len()) {
            if let Some(zero) = self.zeros.get(i) {
                value *= point - zero;
            }
            if let Some(pole) = self.poles.get(i) {
                value /= point - pole;
            }
        }
        value
    }
}

impl<T: TimeDomain> StateSpace<T> {
    /// Zero-pole-gain form of a single-input single-output system. Nothing is cancelled.
    ///
    /// # Errors
    /// [`LtiError::Shape`] unless there is one input and one output; [`LtiError::Degenerate`];
    /// [`LtiError::EigenvaluesNotConverged`].
    pub fn zero_pole_gain(&self) -> Result<ZeroPoleGain, LtiError> {
        self.require_siso()?;
        let mut form = ZeroPoleGain { zeros: self.zeros()?, poles: self.poles()?, leading_coefficient: 1.0 };
        let excess = form.poles.len().saturating_sub(form.zeros.len());
        form.leading_coefficient = if excess > LARGE_EXCESS {
            self.markov(excess)
        } else {
            // A real point beyond all poles and zeros: no factor is small there, and the ratio is real.
            let radius = form.zeros.iter().chain(&form.poles).map(|v| v.norm()).fold(0.0, f64::max);
            let point = C64::new(if radius > 0.0 { 2.0 * radius } else { 1.0 }, 0.0);
            TransferEvaluator::new(self).at(point)?[(0, 0)].re / form.at(point).re
        };
        Ok(form)
    }

    /// C A^(step - 1) B of one input and one output.
    fn markov(&self, step: usize) -> f64 {
        // Powers of two are kept apart, since powers of A soon leave the range of doubles.
        let (mut reached, mut exponent) = (self.b().clone(), 0.0);
        for _ in 1..step {
            reached = self.a() * reached;
            let size = reached.amax().log2().floor();
            if size.is_finite() {
                reached *= (-size).exp2();
                exponent += size;
            }
        }
        (self.c() * reached)[(0, 0)] * (0.5 * exponent).exp2() * (0.5 * exponent).exp2()
    }
}
