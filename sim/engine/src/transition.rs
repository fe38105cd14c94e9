//! The exponentials of all lanes side by side, and the look at their guards.

use feeler_lanes::{Lane, LaneMask};

use crate::error::EngineError;
use crate::flow::{ROWS_PER_SLOT, SLOTS_PER_SWITCH};
use crate::lane::LaneCore;

/// Rows that are multiplied together: one AVX-512 register of a single variant.
const BLOCK: usize = 8;

/// Carries every lane over the same span, each in its own mode.
#[derive(Debug)]
pub(crate) struct Transition<L> {
    pub(crate) span_fs: u64,
    /// Flow of each lane for which the rows were filled in.
    filled_for: Vec<usize>,
    /// Equal parts into which each lane cuts the span so as not to miss an event between two looks.
    pub(crate) parts: Vec<u64>,
    /// Length of these parts, s.
    part_s: L,
    /// Blocks of [`BLOCK`] rows, each column by column.
    rows: Vec<L>,
    width: usize,
    states: usize,
    slots: usize,
}

impl<L: Lane> Transition<L> {
    pub(crate) fn new(span_fs: u64, lanes: &[LaneCore]) -> Self {
        let layout = lanes[0].motion.layout();
        let slots = SLOTS_PER_SWITCH * lanes[0].motion.switches().len();
        let (states, width) = (layout.states(), layout.linear_width());
        let blocks = (states + ROWS_PER_SLOT * slots).div_ceil(BLOCK);
        Self {
            span_fs,
            filled_for: vec![usize::MAX; L::WIDTH],
            parts: vec![1; L::WIDTH],
            part_s: L::zero(),
            rows: vec![L::zero(); blocks * BLOCK * width],
            width,
            states,
            slots,
        }
    }

    /// Rows of the product, padded to whole blocks.
    pub(crate) fn len(&self) -> usize {
        self.rows.len() / self.width
    }

    /// Fills in the rows of lanes whose mode has changed since.
    pub(crate) fn refresh(&mut self, lanes: &mut [LaneCore]) -> Result<(), EngineError> {
        for (l, lane) in lanes.iter_mut().enumerate() {
            if self.filled_for[l] == lane.current || lane.has_ended() {
                continue;
            }
            self.filled_for[l] = lane.current;
            let (span_fs, slots, width) = (self.span_fs, self.slots, self.width);
            let flow = lane.flow_mut();
            if !flow.linear {
                continue;
            }
            let span_s = span_fs as f64 * 1e-15;
            self.parts[l] = (span_s / flow.check_s).ceil().max(1.0) as u64;
            self.part_s.set_lane(l, span_s / self.parts[l] as f64);
            let rows = flow.transition(span_fs / self.parts[l], slots)?;
            for (i, row) in rows.chunks_exact(width).enumerate() {
                let block = &mut self.rows[(i / BLOCK) * BLOCK * width..];
                for (j, &value) in row.iter().enumerate() {
                    block[j * BLOCK + i % BLOCK].set_lane(l, value);
                }
            }
        }
        Ok(())
    }

    /// `y = rows * xi`. To be inlined into a dispatched kernel.
    #[inline(always)]
    fn apply(&self, xi: &[L], y: &mut [L]) {
        let width = self.width;
        for (block, out) in self.rows.chunks_exact(BLOCK * width).zip(y.chunks_exact_mut(BLOCK)) {
            let mut sum = [L::zero(); BLOCK];
            for (column, &x) in block.chunks_exact(BLOCK).zip(xi) {
                for i in 0..BLOCK {
                    sum[i] = column[i].mul_add(x, sum[i]);
                }
            }
            out.copy_from_slice(&sum);
        }
    }

    /// Lanes in which a guard may have been crossed on the way: it is not positive at the end, was negative at the start, or falls at the start and rises
    /// at the end so steeply that it may have dipped below zero in between.
    #[inline(always)]
    fn suspects(&self, y: &[L]) -> L::Mask {
        let zero = L::zero();
        let mut suspect = L::Mask::splat(false);
        for guard in y[self.states..].chunks_exact(ROWS_PER_SLOT).take(self.slots) {
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
        self.apply(xi, y);
        let stopped = here & self.suspects(y);
        let moved = here & !stopped;
        for (x, &y) in xi.iter_mut().zip(y.iter()).take(self.states) {
            *x = L::select(moved, y, *x);
        }
        stopped
    }
}
