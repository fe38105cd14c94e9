//! A mode for measurements, and noise.

use std::f64::consts::TAU;

use feeler_lti::{DiscreteStateSpace, StateSpace};
use nalgebra::{DMatrix, DVector, dmatrix};

pub(crate) const PERIOD_S: f64 = 1e-3;

/// A portable stream of numbers in [0, 1): Steele, Lea and Flood's `SplitMix64` (OOPSLA 2014).
pub(crate) struct Uniform(pub(crate) u64);

impl Uniform {
    pub(crate) fn draw(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / 2_f64.powi(53)
    }

    /// Nearly normal numbers: the sum of twelve uniform ones.
    pub(crate) fn normal(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| (0..12).map(|_| self.draw()).sum::<f64>() - 6.0).collect()
    }
}

/// A sampled mode at 40 Hz with 20 % damping.
pub(crate) fn plant() -> DiscreteStateSpace {
    let w = TAU * 40.0;
    let mode = StateSpace::new(
        dmatrix![0.0, 1.0; -w * w, -0.4 * w],
        dmatrix![0.0; w * w],
        dmatrix![1.0, 0.0],
        dmatrix![0.0],
    );
    mode.unwrap().zero_order_hold(PERIOD_S).unwrap()
}

/// The output for an input from rest.
pub(crate) fn respond(system: &DiscreteStateSpace, input: &[f64]) -> Vec<f64> {
    let inputs = DMatrix::from_row_slice(1, input.len(), input);
    system.respond(&DVector::zeros(system.states()), &inputs).unwrap().iter().copied().collect()
}
