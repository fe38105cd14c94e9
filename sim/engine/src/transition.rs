//! The exponentials of all lanes side by side, and the look at their guards.

use feeler_lanes::{Blocks, Lane, LaneMask};

use crate::error::EngineError;
use crate::flow::ROWS_PER_GUARD;
use crate::lane::LaneCore;

/// Carries every lane over the same span, each in its own mode.
#[derive(Debug)]
pub(crate) struct Transition<L> {
    pub(crate) span_fs: u64,
    /// Formation of the lanes (see [`crate::formation`]) for which the rows were last looked through.
    filled_at: u64,
    /// Flow of each lane for which the rows were filled in.
    filled_for: Vec<usize>,
    /// Equal parts into which each lane cuts the span so as not to miss an event between two looks.
    pub(crate) parts: Vec<u64>,
    /// Most of these.
    pub(crate) most_parts: u64,
    /// Length of these parts, s.
    part_s: L,
    matrix: Blocks<L>,
    width: usize,
    states: usize,
    /// Guards that there is room for.
    guards: usize,
}

impl<L: Lane> Transition<L> {
    pub(crate) fn new(span_fs: u64, lanes: &[LaneCore]) -> Self {
        let layout = lanes[0].motion.layout();
        let (states, width) = (layout.states(), layout.linear_width());
        Self {
            span_fs,
            filled_at: 0,
            filled_for: vec![usize::MAX; L::WIDTH],
            parts: vec![1; L::WIDTH],
            most_parts: 1,
            part_s: L::zero(),
            matrix: Blocks::zeros(states, width),
            width,
            states,
            guards: 0,
        }
    }

    /// Rows of the product, padded.
    pub(crate) fn padded_rows(&self) -> usize {
        self.matrix.padded_rows()
    }

    /// Fills in the rows of lanes whose mode has changed since.
    #[inline(always)]
    pub(crate) fn refresh(&mut self, formation: u64, lanes: &mut [LaneCore]) -> Result<(), EngineError> {
        if self.filled_at == formation {
            return Ok(());
        }
        self.filled_at = formation;
        self.fill(lanes)
    }

    #[cold]
    fn fill(&mut self, lanes: &mut [LaneCore]) -> Result<(), EngineError> {
        let most = lanes.iter().map(|lane| lane.flow().equations.guards.len()).max().unwrap_or(0);
        if most > self.guards {
            self.guards = most;
            self.matrix = Blocks::zeros(self.states + ROWS_PER_GUARD * most, self.width);
            self.filled_for.fill(usize::MAX);
        }
        for (l, lane) in lanes.iter_mut().enumerate() {
            if self.filled_for[l] == lane.current || lane.has_ended() {
                continue;
            }
            self.filled_for[l] = lane.current;
            let flow = lane.flow_mut();
            if !flow.linear {
                continue;
            }
            let span_s = self.span_fs as f64 * 1e-15;
            // Where nothing can happen there is nothing to look for.
            self.parts[l] = if flow.equations.guards.is_empty() { 1 } else { (span_s / flow.check_s).ceil().max(1.0) as u64 };
            self.part_s.set_lane(l, span_s / self.parts[l] as f64);
            let rows = flow.transition(self.span_fs / self.parts[l])?;
            for (i, row) in rows.chunks_exact(self.width).enumerate() {
                self.matrix.set_row(l, i, row);
            }
            // Guards that this lane does not have read 1 at both ends.
            let mut one = vec![0.0; self.width];
            one[self.width - 1] = 1.0;
            for i in rows.len() / self.width..self.states + ROWS_PER_GUARD * self.guards {
                let is_value = matches!((i - self.states) % ROWS_PER_GUARD, 0 | 3);
                self.matrix.set_row(l, i, if is_value { &one } else { &[] });
            }
        }
        self.most_parts = self.parts.iter().copied().max().unwrap_or(1);
        Ok(())
    }

    /// Lanes in which a guard may have been crossed on the way: it is not positive at the end, was negative at the start, or falls at the start and rises
    /// at the end so steeply that it may have dipped below zero in between.
    #[inline(always)]
    fn suspects(&self, y: &[L]) -> L::Mask {
        let zero = L::zero();
        let mut suspect = L::Mask::splat(false);
        for guard in y[self.states..].chunks_exact(ROWS_PER_GUARD).take(self.guards) {
            let [end, slope_start, slope_end, start] = [guard[0], guard[1], guard[2], guard[3]];
            // Where the tangents at both ends meet below zero (see `taylor::Polynomial::dip`).
            let below = (slope_end * start - slope_start * end + slope_start * slope_end * self.part_s).lt(zero);
            let dips = slope_start.lt(zero) & slope_end.gt(zero) & below;
            suspect = suspect | end.le(zero) | start.lt(zero) | dips;
        }
        suspect
    }

    /// Moves the lanes of `here` by one part, but for those that may have met an event: these stay where they are, and are given.
    #[inline(always)]
    pub(crate) fn step(&self, here: L::Mask, xi: &mut [L], y: &mut [L]) -> L::Mask {
        self.matrix.apply(xi, y);
        let stopped = here & self.suspects(y);
        if here.all() && !stopped.any() {
            xi[..self.states].copy_from_slice(&y[..self.states]);
            return stopped;
        }
        let moved = here & !stopped;
        for (x, &y) in xi.iter_mut().zip(y.iter()).take(self.states) {
            *x = L::select(moved, y, *x);
        }
        stopped
    }
}
