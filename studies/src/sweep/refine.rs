//! Refines a grid along boundaries, and only there.
//!
//! The grid is the coarsest level of a lattice. Its spacing is halved repeatedly, along each axis as often as
//! its tolerance requires. A cell is split if two of its known points differ in class. They must be
//! neighbours along an axis that is not yet at its finest. It is split along all such axes, until no such
//! cell is left. A boundary is then located to one spacing of the finest grid, and the number of runs grows
//! with its length, not with the area. If one axis reaches its tolerance long before the other, only the
//! points where the boundary crosses its lines are located.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::error::SweepError;
use super::points::{Node, Points};
use super::store::{ChunkId, Store};
use super::table::SweepTable;
use super::{Counters, Sweep};
use crate::run::{Outcome, nothing_can_touch};
use feeler_files::Refine;

/// A rectangle (or, with one axis, a section) of the lattice.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct GridCell {
    corner: Node,
    sizes: Vec<u64>,
}

impl GridCell {
    /// The points from the corner on at multiples of `steps` within the cell.
    fn nodes(&self, steps: &[u64]) -> Vec<Node> {
        let mut nodes = vec![Node::new()];
        for ((&base, &size), &step) in self.corner.iter().zip(&self.sizes).zip(steps) {
            let along = |node: Node| {
                (0..=size / step).map(move |i| node.iter().copied().chain([base + i * step]).collect())
            };
            nodes = nodes.into_iter().flat_map(along).collect();
        }
        nodes
    }

    fn corners(&self) -> Vec<Node> {
        self.nodes(&self.sizes)
    }

    /// Half of each side, unless it is the finest.
    fn halves(&self) -> Vec<u64> {
        self.sizes.iter().map(|size| (size / 2).max(1)).collect()
    }

    fn children(&self) -> Vec<Self> {
        let halves = self.halves();
        let begins = |node: &Node| {
            node.iter().zip(&self.corner).zip(&self.sizes).all(|((at, corner), size)| at - corner < *size)
        };
        let corners = self.nodes(&halves).into_iter().filter(begins);
        corners.map(|corner| Self { corner, sizes: halves.clone() }).collect()
    }

    /// Whether two known neighbours along an axis that can be split differ.
    fn is_crossed<'a>(&self, class: &impl Fn(&Node) -> Option<&'a str>) -> bool {
        let halves = self.halves();
        let known: Vec<(Node, &str)> = self
            .nodes(&halves)
            .into_iter()
            .filter_map(|node| class(&node).map(|class| (node, class)))
            .collect();
        let beside = |a: &Node, b: &Node, axis: usize| {
            a.iter().zip(b).enumerate().all(|(i, (a, b))| i == axis || a == b)
        };
        let differs = |axis: usize| {
            known
                .iter()
                .enumerate()
                .any(|(i, (a, of_a))| known[..i].iter().any(|(b, of_b)| of_a != of_b && beside(a, b, axis)))
        };
        (0..self.sizes.len()).any(|axis| self.sizes[axis] > 1 && differs(axis))
    }
}

/// Corners of the coarsest cells.
fn coarse(counts: &[u64], strides: &[u64]) -> Vec<Node> {
    let mut corners = vec![Node::new()];
    for (&count, &stride) in counts.iter().zip(strides) {
        let steps: Vec<u64> = (0..(count - 1) / stride).map(|i| i * stride).collect();
        corners = corners
            .iter()
            .flat_map(|corner| steps.iter().map(move |s| corner.iter().copied().chain([*s]).collect()))
            .collect();
    }
    corners
}

/// Classes of the variants; `None` for a variant that failed or was undecided. `at_rest_away` means that a
/// variant without contact is at rest.
fn classes_of(table: &SweepTable, refine: Refine, at_rest_away: bool) -> Vec<Option<String>> {
    let text = |column: &str, row: usize| table.texts(column)?.get(row)?.clone();
    let class = |row: usize| {
        let outcome = text("outcome", row)?;
        let known = Outcome::ALL.iter().find(|(_, name)| *name == outcome).map(|(outcome, _)| *outcome)?;
        let stable = match known {
            Outcome::Undecided => match text("undecided", row)?.as_str() {
                "still-decaying" => true,
                "still-growing" => false,
                _ => return None,
            },
            _ if refine.by_outcome => return Some(outcome),
            Outcome::NoContact => at_rest_away,
            _ => known.is_stable(),
        };
        Some(if stable { "stable" } else { "unstable" }.to_owned())
    };
    (0..table.rows).map(class).collect()
}

impl Sweep {
    /// Runs pass after pass until no cell needs a split, and returns the chunks of each.
    pub(super) fn run_refined(
        &self,
        refine: Refine,
        folder: &Path,
        store: &Store,
        counters: &Counters<'_>,
    ) -> Result<Vec<Vec<ChunkId>>, SweepError> {
        let file = &self.file;
        let strides: Vec<u64> = (0..file.axes.len()).map(|axis| refine.stride(axis)).collect();
        let counts: Vec<u64> = file
            .axes
            .values()
            .zip(&strides)
            .map(|(axis, stride)| (axis.count().unwrap_or(2) - 1) * stride + 1)
            .collect();
        let mut leaves: Vec<GridCell> = coarse(&counts, &strides)
            .into_iter()
            .map(|corner| GridCell { corner, sizes: strides.clone() })
            .collect();
        let mut classes: BTreeMap<Node, Option<String>> = BTreeMap::new();
        let mut wanted: BTreeSet<Node> = leaves.iter().flat_map(GridCell::corners).collect();
        let at_rest_away = nothing_can_touch(&self.document.scenario);
        let mut passes = Vec::new();
        while !wanted.is_empty() {
            let nodes: Vec<Node> = std::mem::take(&mut wanted).into_iter().collect();
            let points = Points::Nodes(file, nodes.clone(), counts.clone());
            let ids =
                self.pass(&points, passes.len(), classes.len() as u64, None, folder, store, counters)?;
            let mut found = nodes.into_iter();
            for id in &ids {
                classes.extend(found.by_ref().zip(classes_of(&store.read(*id)?, refine, at_rest_away)));
            }
            passes.push(ids);
            let class = |node: &Node| classes.get(node)?.as_deref();
            // A cell may differ only after its neighbours were split, and cells whose points are all known
            // are split again immediately.
            while wanted.is_empty() {
                let (split, whole): (Vec<GridCell>, Vec<GridCell>) =
                    leaves.into_iter().partition(|cell| cell.is_crossed(&class));
                leaves = whole;
                if split.is_empty() {
                    break;
                }
                let children: Vec<GridCell> = split.iter().flat_map(GridCell::children).collect();
                wanted.extend(
                    children.iter().flat_map(GridCell::corners).filter(|node| !classes.contains_key(node)),
                );
                leaves.extend(children);
            }
        }
        Ok(passes)
    }

    /// Runs that a grid of the same fineness would take; `None` if the sweep is not adaptive.
    pub fn runs_of_the_grid(&self) -> Option<u64> {
        let refine = self.file.refine?;
        let axes = self.file.axes.values().enumerate();
        Some(axes.map(|(i, axis)| (axis.count().unwrap_or(2) - 1) * refine.stride(i) + 1).product())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On which side of `y = 2 x` a place lies.
    fn side(node: &Node) -> &'static str {
        if node[1] > 2 * node[0] { "above" } else { "below" }
    }

    /// For a column one spacing wide only the two long sides count: differences across it are already
    /// located.
    #[test]
    fn truth_a_cell_at_its_tolerance_is_split_only_along_the_other_axis() {
        let column = GridCell { corner: vec![3, 0], sizes: vec![1, 8] };
        assert_eq!(column.children().len(), 2);
        assert!(column.is_crossed(&|node| Some(side(node))));
        let beside = |node: &Node| Some(if node[0] > 3 { "right" } else { "left" });
        assert!(!column.is_crossed(&beside));
        assert!(!GridCell { corner: vec![3, 6], sizes: vec![1, 1] }.is_crossed(&|node| Some(side(node))));
    }

    /// If both axes can be split, it does not matter along which of them the class changes.
    #[test]
    fn truth_squares_are_split_into_four() {
        let square = GridCell { corner: vec![0, 0], sizes: vec![4, 4] };
        assert!(square.is_crossed(&|node| Some(side(node))) && square.corners().len() == 4);
        let children = square.children();
        assert_eq!(
            children.iter().map(|cell| (cell.corner[0], cell.corner[1])).collect::<Vec<_>>(),
            [(0, 0), (0, 2), (2, 0), (2, 2)]
        );
        assert!(children.iter().all(|cell| cell.sizes == [2, 2]));
    }
}
