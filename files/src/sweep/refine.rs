//! Refinement of a grid along boundaries.

use feeler_catalogue::{Content, Contents};
use indexmap::IndexMap;

use super::super::keys::sweep::{AXES, AXIS_TOLERANCE, BY, BY_OUTCOME, LEVELS, REFINE_TABLE, TOLERANCE};
use super::super::problem::Problems;
use super::super::read::join;
use super::super::tree::Table;
use super::axes::{ReadAxis, SweepAxis};

/// Default number of bisections of the spacing, without a tolerance.
const USUAL_LEVELS: u32 = 4;
const MOST_LEVELS: u32 = 12;

/// Refinement of a grid with one or two axes, between neighbours that differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refine {
    /// Number of bisections of the spacing of each axis, in the order of the file, as the axis's tolerance
    /// requires.
    pub levels: [u32; 2],
    /// The property that defines a boundary: the outcome itself, or only whether the force settles.
    pub by_outcome: bool,
}

impl Refine {
    /// From the fields of `[refine]` and the tolerances of the axes, which are shares of their length.
    pub(super) fn read(
        fields: &Contents,
        root: &Table,
        axes: &IndexMap<String, ReadAxis>,
        problems: &mut Problems,
    ) -> Option<Self> {
        let Some(entry) = root.get(REFINE_TABLE) else {
            for (key, (_, origin)) in
                axes.iter().filter_map(|(key, read)| Some((key, read.tolerance.as_ref()?)))
            {
                let message = "a tolerance applies only to a grid that is refined along boundaries";
                problems.add(
                    origin,
                    format!("{AXES}.\"{key}\".{}", AXIS_TOLERANCE.name),
                    message,
                    "add [refine], or remove it",
                );
            }
            return None;
        };
        let table = entry.node.as_table();
        let origin = |key: &str| {
            table.and_then(|table| table.get(key)).map_or(&entry.node.origin, |entry| &entry.node.origin)
        };
        let of_all = fields.value::<f64>(&TOLERANCE).map(|share| (share, origin(TOLERANCE.name)));
        let of_each =
            |read: &ReadAxis| read.tolerance.as_ref().map(|(share, origin)| (*share, origin.clone()));
        let wanted = axes.iter().filter_map(|(key, read)| {
            let (share, at) = of_each(read).or(of_all.map(|(share, origin)| (share, origin.clone())))?;
            let spacings = read.axis.count()?.saturating_sub(1).max(1);
            Some((key, at, halvings(share * spacings as f64)))
        });
        let given = fields.value::<u32>(&LEVELS);
        let mut levels = [given.unwrap_or(USUAL_LEVELS); 2];
        for (key, at, needed) in wanted {
            if given.is_some() {
                problems.add(
                    origin(LEVELS.name),
                    join(REFINE_TABLE, LEVELS.name),
                    "`levels` and a tolerance say the same thing",
                    "remove one of them",
                );
                break;
            }
            if needed > MOST_LEVELS {
                let message = format!(
                    "this takes {needed} halvings of the spacing of `{key}`, and at most {MOST_LEVELS} are \
                     done"
                );
                problems.add(
                    &at,
                    format!("{AXES}.\"{key}\""),
                    message,
                    "use more points, or a larger tolerance",
                );
            }
            if let Some(levels) = axes.get_index_of(key).and_then(|axis| levels.get_mut(axis)) {
                *levels = needed.min(MOST_LEVELS);
            }
        }
        Some(Self { levels, by_outcome: fields.get(BY.name) == Some(&Content::Word(BY_OUTCOME)) })
    }

    /// Number of finest spacings in one spacing of the axis at an index.
    pub fn stride(&self, axis: usize) -> u64 {
        self.levels.get(axis).map_or(1, |levels| 1 << levels)
    }

    /// The finest spacing of the axis at an index as a share of its length: the accuracy of an edge.
    pub fn share(&self, index: usize, axis: &SweepAxis) -> f64 {
        let spacings = axis.count().unwrap_or(2).saturating_sub(1).max(1);
        1.0 / (spacings * self.stride(index)) as f64
    }
}

/// Number of bisections of a spacing of 1 until it is at most `tolerance`.
fn halvings(tolerance: f64) -> u32 {
    // A power of two up to rounding counts as exact.
    (-tolerance.log2() - 1e-9).ceil().clamp(0.0, 99.0) as u32
}
