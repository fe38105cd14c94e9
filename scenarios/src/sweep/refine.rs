//! Makes a grid finer along boundaries, and only there.
//!
//! The grid is the coarsest level of a lattice whose spacing is halved so many times. A cell whose known corners and edge midpoints differ in class is
//! split, until no cell larger than the finest differs; a boundary is then known to one spacing of the finest grid for a number of runs that grows with
//! its length, not with the area.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::error::SweepError;
use super::points::{Node, Points};
use super::store::{ChunkId, Store};
use super::table::Table;
use super::{Counters, Sweep};
use crate::format::{Refine, SweepFile};
use crate::run::{Outcome, nothing_can_touch};

/// A square (or, with one axis, a section) of the lattice.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Cell {
    corner: Node,
    size: u64,
}

impl Cell {
    /// The places at multiples of `step` from the corner.
    fn nodes(&self, step: u64) -> Vec<Node> {
        let offsets: Vec<u64> = (0..=self.size / step).map(|i| i * step).collect();
        let mut nodes = vec![Node::new()];
        for &base in &self.corner {
            nodes = nodes.iter().flat_map(|node| offsets.iter().map(move |o| node.iter().copied().chain([base + o]).collect())).collect();
        }
        nodes
    }

    fn children(&self) -> Vec<Self> {
        let half = self.size / 2;
        let corners = Self { corner: self.corner.clone(), size: half }.nodes(half);
        corners.into_iter().map(|corner| Self { corner, size: half }).collect()
    }
}

/// Runs pass after pass until no cell is to be split, and gives the chunks of each.
pub(super) fn run(
    sweep: &Sweep,
    refine: Refine,
    folder: &Path,
    store: &Store,
    counters: &Counters<'_>,
) -> Result<Vec<Vec<ChunkId>>, SweepError> {
    let file = &sweep.file;
    let stride = 1_u64 << refine.levels;
    let counts: Vec<u64> = file.axes.values().map(|axis| (axis.count().unwrap_or(2) - 1) * stride + 1).collect();
    let mut leaves: Vec<Cell> = coarse(&counts, stride).into_iter().map(|corner| Cell { corner, size: stride }).collect();
    let mut classes: BTreeMap<Node, Option<String>> = BTreeMap::new();
    let mut wanted: BTreeSet<Node> = leaves.iter().flat_map(|cell| cell.nodes(stride)).collect();
    let at_rest_away = nothing_can_touch(&sweep.document.scenario);
    let mut passes = Vec::new();
    while !wanted.is_empty() {
        let nodes: Vec<Node> = std::mem::take(&mut wanted).into_iter().collect();
        let points = Points::Nodes(file, nodes.clone(), counts.clone());
        let ids = sweep.pass(&points, passes.len(), classes.len() as u64, None, folder, store, counters)?;
        let mut found = nodes.into_iter();
        for id in &ids {
            classes.extend(found.by_ref().zip(classes_of(&store.read(*id)?, refine, at_rest_away)));
        }
        passes.push(ids);
        let differs = |cell: &Cell| {
            let known: Vec<&String> = cell.nodes(cell.size / 2).iter().filter_map(|node| classes.get(node)?.as_ref()).collect();
            known.windows(2).any(|pair| pair[0] != pair[1])
        };
        // A cell may come to differ only after its neighbours were split, and cells whose places are all known are split again at once.
        while wanted.is_empty() {
            let (split, whole): (Vec<Cell>, Vec<Cell>) = leaves.into_iter().partition(|cell| cell.size > 1 && differs(cell));
            leaves = whole;
            if split.is_empty() {
                break;
            }
            let children: Vec<Cell> = split.iter().flat_map(Cell::children).collect();
            wanted.extend(children.iter().flat_map(|cell| cell.nodes(cell.size)).filter(|node| !classes.contains_key(node)));
            leaves.extend(children);
        }
    }
    Ok(passes)
}

/// Corners of the coarsest cells.
fn coarse(counts: &[u64], stride: u64) -> Vec<Node> {
    let mut corners = vec![Node::new()];
    for &count in counts {
        let steps: Vec<u64> = (0..(count - 1) / stride).map(|i| i * stride).collect();
        corners = corners.iter().flat_map(|corner| steps.iter().map(move |s| corner.iter().copied().chain([*s]).collect())).collect();
    }
    corners
}

/// What tells one side of a boundary from the other; none of a variant that failed or was undecided. `at_rest_away` says that a variant without contact
/// is at rest.
fn classes_of(table: &Table, refine: Refine, at_rest_away: bool) -> Vec<Option<String>> {
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

/// Runs of a grid as fine as the finest level.
pub(super) fn runs_of_the_grid(file: &SweepFile, refine: Refine) -> u64 {
    file.axes.values().map(|axis| ((axis.count().unwrap_or(2) - 1) << refine.levels) + 1).product()
}
