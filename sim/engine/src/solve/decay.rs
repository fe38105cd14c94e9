//! Pieces of a linear mode whose fastest part has decayed.
//!
//! A drive of 1 GHz or a light body behind a damper decays within nanoseconds, and Taylor polynomials of such
//! a mode reach no farther. After that decay the motion is as slow as the remaining part, and exponentials
//! carry it over spans that fit that part.

use feeler_plant::motion::dot;
use nalgebra::DVector;

use crate::solve::crossing::Piece;
use crate::solve::flow::Flow;

/// Number of polynomials per span from which exponentials are used for a mode whose fast part has decayed. An
/// exponential costs about as much as twenty polynomials.
const MANY_POLYNOMIALS: f64 = 100.0;
/// Time constants after which a part has decayed below rounding: exp(-40) is 4e-18.
const TIME_CONSTANTS: f64 = 40.0;
/// Largest angle of the remaining motion in one piece, rad: as between two evaluations of guards.
const REACH: f64 = 1.2;

impl Flow {
    /// Length of a piece `calm_s` after the last event, if it is much longer than the reach of a polynomial.
    pub(crate) fn reach_beyond_decay_s(&mut self, calm_s: f64, span_s: f64) -> Option<f64> {
        if span_s < MANY_POLYNOMIALS * self.horizon_s || calm_s * self.rate < TIME_CONSTANTS {
            return None;
        }
        let left = self.poles().ok()?.iter().filter(|pole| -pole.re * calm_s < TIME_CONSTANTS);
        let reach_s = REACH / left.map(|pole| pole.norm()).fold(REACH / span_s, f64::max);
        (reach_s > MANY_POLYNOMIALS * self.horizon_s).then_some(reach_s)
    }
}

/// A piece of a mode whose fastest part has decayed.
pub(crate) struct Decay<'a> {
    flow: &'a mut Flow,
    start: Vec<f64>,
}

impl<'a> Decay<'a> {
    pub(crate) fn new(flow: &'a mut Flow, xi: &[f64]) -> Self {
        Self { start: xi.to_vec(), flow }
    }
}

impl Piece for Decay<'_> {
    fn flow(&self) -> &Flow {
        self.flow
    }

    fn state(&mut self, s: f64) -> Option<Vec<f64>> {
        let mut xi = self.start.clone();
        if s > 0.0 {
            let (states, width) = (self.flow.states, self.flow.width);
            let moved = self.flow.exponential(s)? * DVector::from_column_slice(&self.start[..width]);
            xi[..states].copy_from_slice(&moved.as_slice()[..states]);
        }
        Some(xi)
    }

    fn slope(&self, row: &[f64], xi: &[f64], _span_s: f64) -> f64 {
        dot(&self.flow.slope(row), &xi[..self.flow.width])
    }
}
