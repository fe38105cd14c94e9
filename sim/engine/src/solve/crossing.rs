//! Where a guard of a nonlinear mode is crossed within a step.

use feeler_plant::motion::modes::{Course, Instant, first_crossing, trace};
use feeler_plant::motion::{Motion, dot};

use crate::solve::extrapolation::Extrapolation;
use crate::solve::flow::Flow;

/// An event is located to this, s.
const LOCATED_S: f64 = 1e-15;
/// Share of a step over which a slope is taken.
const SLOPE_SHARE: f64 = 1e-5;

/// A guard looked at along a step that has been taken.
pub(crate) struct Look<'a> {
    pub(crate) motion: &'a Motion,
    pub(crate) flow: &'a Flow,
    /// Where the step started.
    pub(crate) start: &'a [f64],
    /// The guard, or another functional.
    pub(crate) row: &'a [f64],
}

impl Look<'_> {
    /// The first instant in `[0, h]` at which the guard fires (see [`feeler_plant::motion::Guard`]); `end` is
    /// the state at `h`.
    pub(crate) fn first_crossing(&self, method: &mut Extrapolation, end: &[f64], h: f64) -> Option<f64> {
        let start = Instant { s: 0.0, value: dot(self.row, self.start), slope: self.slope(self.start, h) };
        let end = Instant { s: h, value: dot(self.row, end), slope: self.slope(end, h) };
        let trace = trace(self.row, self.start, start.slope);
        first_crossing(&mut Steps { look: self, method }, [start, end], trace, LOCATED_S)
    }

    /// The state `s` after the start: a fresh step, so that its error is that of one step.
    pub(crate) fn at(&self, method: &mut Extrapolation, s: f64) -> Option<Vec<f64>> {
        let mut xi = self.start.to_vec();
        self.motion.fill_terms(&self.flow.equations, &mut xi);
        let mut reached = 0.0;
        while reached < s {
            reached += method.step(self.motion, self.flow, &mut xi, &mut [], s - reached)?;
        }
        Some(xi)
    }

    /// Slope of the guard along the motion.
    pub(crate) fn slope(&self, xi: &[f64], span_s: f64) -> f64 {
        let delta = SLOPE_SHARE * span_s;
        let mut moved = xi.to_vec();
        for (x, row) in moved.iter_mut().zip(&self.flow.equations.derivative) {
            *x += delta * dot(row, xi);
        }
        self.motion.fill_terms(&self.flow.equations, &mut moved);
        (dot(self.row, &moved) - dot(self.row, xi)) / delta
    }
}

/// Looks by fresh steps from the start.
struct Steps<'a> {
    look: &'a Look<'a>,
    method: &'a mut Extrapolation,
}

impl Course for Steps<'_> {
    fn look(&mut self, s: f64) -> Option<Instant> {
        let xi = self.look.at(self.method, s)?;
        Some(Instant { s, value: dot(self.look.row, &xi), slope: self.look.slope(&xi, s) })
    }

    fn value(&mut self, s: f64) -> Option<f64> {
        Some(dot(self.look.row, &self.look.at(self.method, s)?))
    }
}
