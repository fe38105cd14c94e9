//! Locates guard crossings within a piece whose states are evaluated one by one.

use feeler_plant::motion::modes::{GuardFunction, Instant, first_crossing, trace};
use feeler_plant::motion::{Motion, Row, dot};

use crate::solve::extrapolation::Extrapolation;
use crate::solve::flow::Flow;

/// Accuracy of an event, s.
const LOCATED_S: f64 = 1e-15;
/// Share of a step over which a slope is computed by differences.
const SLOPE_SHARE: f64 = 1e-5;

/// A state along a step, with its meter readings.
#[derive(Clone, Debug)]
pub(crate) struct Known {
    s: f64,
    pub(crate) xi: Vec<f64>,
    pub(crate) meters: Vec<f64>,
}

/// A completed step, and the states known along it. A new state is integrated from the last known one before
/// it: at the start, a contact that has just begun allows only short steps.
pub(crate) struct Path<'a> {
    motion: &'a Motion,
    flow: &'a Flow,
    method: &'a mut Extrapolation,
    /// In order of time; the first is the start.
    known: Vec<Known>,
}

impl<'a> Path<'a> {
    pub(crate) fn new(
        motion: &'a Motion,
        flow: &'a Flow,
        method: &'a mut Extrapolation,
        start: Known,
    ) -> Self {
        Self { motion, flow, method, known: vec![start] }
    }

    /// Records that the step reached `h` in this state.
    pub(crate) fn reaches(&mut self, h: f64, xi: &[f64], meters: &[f64]) {
        self.known.push(Known { s: h, xi: xi.to_vec(), meters: meters.to_vec() });
    }

    /// The state at `s` after the start; `None` if the motion is not finite.
    pub(crate) fn at(&mut self, s: f64) -> Option<&Known> {
        // `s` precedes the start only by rounding; NaN has no state.
        let last = self.known.partition_point(|known| known.s <= s).saturating_sub(1);
        if s <= self.known[last].s {
            return Some(&self.known[last]);
        }
        if s.is_nan() {
            return None;
        }
        let mut here = self.known[last].clone();
        while here.s < s {
            here.s += self.method.step(self.motion, self.flow, &mut here.xi, &mut here.meters, s - here.s)?;
            // The remainder is below the resolution of the clock.
            if s - here.s <= f64::EPSILON * s {
                here.s = s;
            }
        }
        self.known.insert(last + 1, here);
        Some(&self.known[last + 1])
    }
}

impl Piece for Path<'_> {
    fn flow(&self) -> &Flow {
        self.flow
    }

    fn state(&mut self, s: f64) -> Option<Vec<f64>> {
        self.at(s).map(|known| known.xi.clone())
    }

    fn slope(&self, row: &[f64], xi: &[f64], span_s: f64) -> f64 {
        let delta = SLOPE_SHARE * span_s;
        let mut moved = xi.to_vec();
        for (x, row) in moved.iter_mut().zip(&self.flow.equations.derivative) {
            *x += delta * dot(row, xi);
        }
        self.motion.fill_terms(&self.flow.equations, &mut moved);
        (dot(row, &moved) - dot(row, xi)) / delta
    }
}

/// A span of one mode whose states can be evaluated.
pub(crate) trait Piece {
    /// The mode.
    fn flow(&self) -> &Flow;

    /// The extended vector `s` after the start; `None` if the motion is not finite.
    fn state(&mut self, s: f64) -> Option<Vec<f64>>;

    /// Slope of a functional along the motion; differences use a span of this size.
    fn slope(&self, row: &[f64], xi: &[f64], span_s: f64) -> f64;
}

/// The first of a mode's guards to fire in `[0, h]` (see [`feeler_plant::motion::Guard`]), and its time.
pub(crate) fn first_guard(piece: &mut impl Piece, mut h: f64) -> (f64, Option<usize>) {
    let mut event = None;
    let rows: Vec<Row> = piece.flow().equations.guards.iter().map(|guard| guard.row.clone()).collect();
    for (i, row) in rows.iter().enumerate() {
        // Only up to the first guard that fires: beyond it the mode may have no valid motion.
        if let Some(s) = crossing(piece, row, h)
            && (event.is_none() || s < h)
        {
            h = s;
            event = Some(i);
        }
    }
    (h, event)
}

/// The first instant in `[0, h]` at which a guard fires.
fn crossing(piece: &mut impl Piece, row: &[f64], h: f64) -> Option<f64> {
    let (from, to) = (piece.state(0.0)?, piece.state(h)?);
    let ends = [(0.0, &from), (h, &to)].map(|(s, xi)| Instant {
        s,
        value: dot(row, xi),
        slope: piece.slope(row, xi, h),
    });
    let trace = trace(row, &from, ends[0].slope);
    first_crossing(&mut GuardOnPiece { piece, row }, ends, trace, LOCATED_S)
}

/// Evaluates a functional along a piece.
struct GuardOnPiece<'p, L> {
    piece: &'p mut L,
    row: &'p [f64],
}

impl<L: Piece> GuardFunction for GuardOnPiece<'_, L> {
    fn at(&mut self, s: f64) -> Option<Instant> {
        let xi = self.piece.state(s)?;
        Some(Instant { s, value: dot(self.row, &xi), slope: self.piece.slope(self.row, &xi, s) })
    }

    fn value(&mut self, s: f64) -> Option<f64> {
        Some(dot(self.row, &self.piece.state(s)?))
    }
}

impl Known {
    /// The start of a step, with terms filled in.
    pub(crate) fn start(xi: &[f64], meters: &[f64]) -> Self {
        Self { s: 0.0, xi: xi.to_vec(), meters: meters.to_vec() }
    }
}
