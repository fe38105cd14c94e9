//! Signals of the plant that controllers and recorders read, for all lanes.

use feeler_lanes::{Blocks, Lane, LaneMask};
use feeler_plant::motion::dot;

use crate::carry::formation::Formation;
use crate::carry::lane::LaneCore;

/// The wanted signals side by side. A lane's signals come with its motion, or from the rows of its mode.
#[derive(Debug)]
pub(super) struct Signals<L: Lane> {
    pub(super) values: Vec<L>,
    /// The signals at the note of the last interval, for late readings. All other signals are zero.
    pub(super) noted: Vec<L>,
    /// Lanes whose signals came with their motion to the present instant.
    pub(super) are_fresh: L::Mask,
    /// Results of the rows, padded.
    products: Vec<L>,
    rows: Blocks<L>,
    /// Flow of each lane for which its rows were filled in.
    filled_for: Vec<usize>,
    /// Formation for which the rows were last checked.
    filled_at: u64,
}

impl<L: Lane> Signals<L> {
    pub(super) fn new(count: usize, width: usize) -> Self {
        let rows = Blocks::zeros(count, width);
        Self {
            values: vec![L::zero(); count],
            noted: vec![L::zero(); count],
            are_fresh: L::Mask::splat(false),
            products: vec![L::zero(); rows.padded_rows()],
            rows,
            filled_for: vec![usize::MAX; L::WIDTH],
            filled_at: 0,
        }
    }

    /// Computes the signals of lanes that are not up to date. Actions at the instant change inputs, so no
    /// lane is up to date afterwards.
    #[inline(always)]
    pub(super) fn refresh(&mut self, formation: &Formation<L>, cores: &[LaneCore], xi: &[L]) {
        if !self.are_fresh.all() {
            self.compute(formation, cores, xi);
        }
        self.are_fresh = L::Mask::splat(false);
    }

    #[inline(always)]
    fn compute(&mut self, formation: &Formation<L>, cores: &[LaneCore], xi: &[L]) {
        if self.filled_at != formation.number {
            self.fill(formation.number, cores);
        }
        self.rows.apply(xi, &mut self.products);
        for (value, &product) in self.values.iter_mut().zip(&self.products) {
            *value = L::select(self.are_fresh, *value, product);
        }
    }

    /// Notes some signals of lane `l`, which has passed its note alone.
    #[cold]
    pub(super) fn note(&mut self, l: usize, core: &LaneCore, signals: &[usize]) {
        let (flow, xi) = core.noted();
        for &signal in signals {
            let value = flow.signals[signal].as_ref().map_or(0.0, |row| dot(row, xi));
            self.noted[signal].set_lane(l, value);
        }
    }

    #[cold]
    fn fill(&mut self, formation: u64, cores: &[LaneCore]) {
        self.filled_at = formation;
        for (l, core) in cores.iter().enumerate() {
            if self.filled_for[l] != core.current {
                self.filled_for[l] = core.current;
                for (i, row) in core.flow().signals.iter().enumerate() {
                    self.rows.set_row(l, i, row.as_deref().unwrap_or_default());
                }
            }
        }
    }
}
