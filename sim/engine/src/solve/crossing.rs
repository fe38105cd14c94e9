//! Where a guard of a nonlinear mode is crossed within a step.

use feeler_plant::motion::{Motion, dot};

use crate::solve::extrapolation::Extrapolation;
use crate::solve::flow::Flow;

/// A guard this close to zero, relative to the terms it is made of, may be the trace of the event that has
/// just happened ...
const AT_ZERO: f64 = 1e-12;
/// ... and so may one that was at zero this short a time ago, s (see [`crate::solve::taylor`]).
const AT_ZERO_S: f64 = 1e-13;
/// An event is located to this, s.
const LOCATED_S: f64 = 1e-15;
/// Share of a step over which a slope is taken.
const SLOPE_SHARE: f64 = 1e-5;

/// Halvings of a step in search of an instant at which a guard has grown from zero.
const HALVINGS: i32 = 50;

/// A guard at an instant of the step.
#[derive(Clone, Copy)]
struct Instant {
    s: f64,
    value: f64,
    slope: f64,
}

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
    /// The first instant in `[0, h]` at which the guard, positive before, is no longer positive; `end` is the
    /// state at `h`.
    ///
    /// A value at zero that is the rounded trace of an event counts as positive if it grows, and has already
    /// crossed if it does not.
    pub(crate) fn first_crossing(&self, method: &mut Extrapolation, end: &[f64], h: f64) -> Option<f64> {
        let at_start = Instant { s: 0.0, value: dot(self.row, self.start), slope: self.slope(self.start, h) };
        let at_end = Instant { s: h, value: dot(self.row, end), slope: self.slope(end, h) };
        let size: f64 = self.row.iter().zip(self.start).map(|(r, x)| (r * x).abs()).sum();
        let trace = AT_ZERO * size + AT_ZERO_S * at_start.slope.abs();
        if at_start.value < -trace {
            return Some(0.0);
        }
        let mut left = at_start;
        if at_start.value <= trace {
            let grown = (3..HALVINGS).find_map(|k| {
                let instant = self.look(method, h * 0.5_f64.powi(k))?;
                (instant.value > 0.0).then_some(instant)
            });
            match grown {
                Some(instant) => left = instant,
                None => return (at_end.value < 0.0).then_some(0.0),
            }
        }
        let right = if at_end.value > 0.0 { self.dip(method, left, at_end, h)? } else { at_end };
        self.locate(method, left, right)
    }

    /// The guard `s` after the start.
    fn look(&self, method: &mut Extrapolation, s: f64) -> Option<Instant> {
        let xi = self.at(method, s)?;
        Some(Instant { s, value: dot(self.row, &xi), slope: self.slope(&xi, s) })
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

    /// An instant between two positive values at which the guard is negative, if its one minimum there is
    /// (see `taylor::Polynomial::dip`).
    fn dip(&self, method: &mut Extrapolation, left: Instant, right: Instant, h: f64) -> Option<Instant> {
        let (mut a, mut b) = (left, right);
        while b.s - a.s > LOCATED_S.max(f64::EPSILON * h) {
            let lowest = (b.slope * a.value - a.slope * b.value + a.slope * b.slope * (b.s - a.s))
                / (b.slope - a.slope);
            if a.slope >= 0.0 || b.slope <= 0.0 || lowest > 0.0 {
                return None;
            }
            let middle = self.look(method, 0.5 * (a.s + b.s))?;
            if middle.value <= 0.0 {
                return Some(middle);
            }
            if middle.slope < 0.0 { a = middle } else { b = middle }
        }
        None
    }

    /// The zero between a positive value and one that is not: regula falsi (Illinois), each look a fresh step
    /// from the start.
    fn locate(&self, method: &mut Extrapolation, left: Instant, right: Instant) -> Option<f64> {
        let (mut a, mut fa, mut b, mut fb) = (left.s, left.value, right.s, right.value);
        while b - a > LOCATED_S.max(4.0 * f64::EPSILON * b) {
            let secant = (a * fb - b * fa) / (fb - fa);
            let s = if secant > a && secant < b { secant } else { 0.5 * (a + b) };
            let value = dot(self.row, &self.at(method, s)?);
            let (from_a, from_b, whole) = (s - a, b - s, b - a);
            if value > 0.0 {
                (a, fa) = (s, value);
                fb = if from_a < 0.1 * whole { 0.5 * fb } else { fb };
            } else {
                (b, fb) = (s, value);
                fa = if from_b < 0.1 * whole { 0.5 * fa } else { fa };
            }
        }
        Some(b)
    }
}
