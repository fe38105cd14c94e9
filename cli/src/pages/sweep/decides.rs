//! Finds which of several random numbers decides whether a variant settles.

use feeler_studies::sweep::{DrawnAxis, Theory};

use super::answer::{self, Halves};
use super::report::Report;
use super::rests;
use crate::pages::parts::Page;

/// Number of axes of a map.
const DRAWN: usize = 2;

impl Report<'_> {
    /// Whether each variant has its own value on every axis.
    pub(super) fn is_random(&self) -> bool {
        self.axes.iter().all(|axis| axis.points.is_none())
    }

    /// For each random number, the numbers of variants that come to rest on both sides of its middle. The
    /// number with the strongest effect comes first.
    pub(super) fn halves(&self) -> Vec<Halves> {
        let of = |axis: &DrawnAxis| {
            let at = self.table.reals(&axis.key)?;
            let points = at.into_iter().zip(&self.outcomes);
            Halves::of(&axis.key, &axis.unit, points.filter_map(|(at, name)| Some((at?, rests(name)?))))
        };
        answer::by_weight(self.axes.iter().filter_map(of).collect())
    }

    /// Moves the two numbers with the strongest effect to the front, so that maps are drawn over them. This
    /// is done only if each variant has its own limit of linear theory, which no map can show. Returns
    /// whether it was done.
    pub(super) fn draw_what_decides(&mut self, theory: &mut Theory) -> bool {
        let Theory::Maps(maps) = theory else { return false };
        let is_shown = maps.iter().any(|map| map.varied.is_empty());
        if is_shown || self.axes.len() <= DRAWN || !self.is_random() || !self.sweep.file.keep.outcome {
            return false;
        }
        let halves = self.halves();
        let mut axes = self.axes.clone();
        axes.sort_by_key(|axis| halves.iter().position(|half| half.key == axis.key).unwrap_or(halves.len()));
        // Duration and noise of a run have no effect on the limit.
        let others = axes[DRAWN..].iter().map(|axis| &axis.key).filter(|key| !key.starts_with("run."));
        let others: Vec<String> = others.cloned().collect();
        if others.is_empty() {
            return false;
        }
        for map in maps {
            map.varied.clone_from(&others);
        }
        self.axes = axes;
        true
    }

    /// A table of the random numbers, the one with the strongest effect first.
    pub(super) fn what_decides(&self, page: &mut Page) {
        if self.axes.len() < 2 || !self.is_random() || !self.sweep.file.keep.outcome {
            return;
        }
        page.heading("Which number decides");
        let rows: Vec<Vec<String>> = self.halves().iter().map(Halves::cells).collect();
        page.table(&["number", "middle", "settle below it", "settle above it"], &[1, 2, 3], &rows);
    }
}
