//! Continuous and discrete time as types: they cannot be confused, and shared code is written once.

use std::fmt::Debug;

use num_complex::Complex;

use crate::error::{LtiError, require_positive};

/// A complex number of double precision.
pub type C64 = Complex<f64>;

/// The stability region of the eigenvalues of a system, and their map to the s plane.
pub trait TimeDomain: Copy + Debug + PartialEq {
    /// The point of the stability boundary at an angular frequency: s = j w, or z = exp(j w T).
    fn boundary_point(self, angular_frequency_rad_per_s: f64) -> C64;
    /// The point at which a transfer function is evaluated for a given s: s itself, or z = exp(s T).
    fn point_of_s(self, s: C64) -> C64;
    /// The s-plane equivalent (rad/s) of an eigenvalue: itself, or ln(z) / T (principal branch; -inf for z =
    /// 0).
    fn s_of_point(self, point: C64) -> C64;
    /// Largest distinguishable angular frequency, rad/s: infinity, or pi / T.
    fn nyquist_rad_per_s(self) -> f64;

    /// Growth rate (1/s) of the motion that belongs to an eigenvalue; negative is stable.
    fn growth_per_s(self, point: C64) -> f64 {
        self.s_of_point(point).re
    }

    /// Frequency |s| / 2 pi (Hz) of an eigenvalue.
    fn frequency_hz(self, point: C64) -> f64 {
        self.s_of_point(point).norm() / std::f64::consts::TAU
    }
}

/// Continuous time: x' = A x + B u.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Continuous;

/// Discrete time: `x[n+1] = A x[n] + B u[n]`, one sample every `period_s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discrete {
    period_s: f64,
}

impl Discrete {
    /// Discrete time with a sample time in seconds.
    ///
    /// # Errors
    /// [`LtiError::OutOfRange`] unless the period is positive and finite.
    pub fn new(period_s: f64) -> Result<Self, LtiError> {
        require_positive("sample time (s)", period_s)?;
        Ok(Self { period_s })
    }

    /// Sample time, s.
    pub fn period_s(self) -> f64 {
        self.period_s
    }
}

impl TimeDomain for Continuous {
    fn boundary_point(self, w: f64) -> C64 {
        C64::new(0.0, w)
    }

    fn point_of_s(self, s: C64) -> C64 {
        s
    }

    fn s_of_point(self, point: C64) -> C64 {
        point
    }

    fn nyquist_rad_per_s(self) -> f64 {
        f64::INFINITY
    }
}

impl TimeDomain for Discrete {
    fn boundary_point(self, w: f64) -> C64 {
        C64::cis(w * self.period_s)
    }

    fn point_of_s(self, s: C64) -> C64 {
        (s * self.period_s).exp()
    }

    fn s_of_point(self, point: C64) -> C64 {
        // ln|z| through |z|^2 - 1 keeps full precision next to the unit circle, where stability is decided.
        let excess = (point.re - 1.0).mul_add(point.re + 1.0, point.im * point.im);
        let ln_norm = if excess.abs() < 0.5 { 0.5 * excess.ln_1p() } else { point.norm().ln() };
        C64::new(ln_norm, point.arg()) / self.period_s
    }

    fn nyquist_rad_per_s(self) -> f64 {
        std::f64::consts::PI / self.period_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A few roundings of exp, ln and atan2.
    const ROUNDING: f64 = 1e-13;

    #[test]
    fn truth_points_of_s_return_to_s() {
        let discrete = Discrete::new(1e-3).unwrap();
        for s in [C64::new(-3.0, 40.0), C64::new(700.0, -3000.0), C64::new(-4000.0, 0.0)] {
            assert!((discrete.s_of_point(discrete.point_of_s(s)) - s).norm() < ROUNDING * s.norm() / 1e-3);
        }
        assert!(discrete.growth_per_s(C64::new(0.0, 0.0)) < -1e300);
    }

    #[test]
    fn truth_bad_period_is_refused() {
        for period_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Discrete::new(period_s), Err(LtiError::OutOfRange { .. })));
        }
    }
}
