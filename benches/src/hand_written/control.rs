//! The sampled force controllers, written out.

use super::fma;

/// Reference force of every machine, N.
const WANTED_N: f64 = 20.0;
/// Sampling of every controller, s.
pub(super) const PERIOD_S: f64 = 1e-3;

/// A controller: it turns readings into commands.
pub trait Control {
    /// The command in N after the next sample of the force.
    fn command_n(&mut self, reading_n: f64) -> f64;
}

/// The controller of the reference machines.
#[derive(Clone, Copy, Debug)]
pub struct Proportional;

impl Proportional {
    const GAIN: f64 = 2.0;
    const LIMIT_N: f64 = 200.0;
}

impl Control for Proportional {
    #[inline(always)]
    fn command_n(&mut self, reading_n: f64) -> f64 {
        fma(Self::GAIN, WANTED_N - reading_n, WANTED_N).clamp(-Self::LIMIT_N, Self::LIMIT_N)
    }
}

/// A PI controller whose integral stops while the command exceeds its limit and the error would increase the
/// excess.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProportionalIntegral {
    integral_n: f64,
}

impl ProportionalIntegral {
    const GAIN: f64 = 0.8;
    const INTEGRAL_GAIN_PER_S: f64 = 5.0;
    const LIMIT_N: f64 = 30.0;
}

impl Control for ProportionalIntegral {
    #[inline(always)]
    fn command_n(&mut self, reading_n: f64) -> f64 {
        let error_n = WANTED_N - reading_n;
        let gained_n = Self::INTEGRAL_GAIN_PER_S * PERIOD_S * error_n;
        let rest_n = fma(Self::GAIN, error_n, WANTED_N);
        let wanted_n = rest_n + self.integral_n + gained_n;
        if wanted_n.abs() <= Self::LIMIT_N || wanted_n * gained_n <= 0.0 {
            self.integral_n += gained_n;
        }
        (rest_n + self.integral_n).clamp(-Self::LIMIT_N, Self::LIMIT_N)
    }
}
