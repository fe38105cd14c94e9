//! The results of a sweep, for programs. The book shows the comments.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use crate::pages::sweep::Tally;

/// The variants of a sweep, or of one of its shards.
#[derive(Serialize)]
pub(super) struct Swept {
    /// The table with a row for each variant; `None` if other shards are still missing.
    table: Option<String>,
    /// Number of variants.
    variants: usize,
    /// Number of variants with each outcome. `error` counts those that could not run, `done` those whose
    /// outcome is not kept. Empty without a table.
    outcomes: BTreeMap<String, usize>,
    /// Largest force of any variant; `None` if peak forces are not kept.
    largest_peak_n: Option<f64>,
}

impl Swept {
    /// All variants, from their table.
    pub(super) fn new(table: &Path, tally: Tally) -> Self {
        Self {
            table: Some(table.display().to_string()),
            variants: tally.rows,
            outcomes: tally.outcomes,
            largest_peak_n: tally.largest_peak_n,
        }
    }

    /// A shard with this number of variants.
    pub(super) fn shard(variants: usize) -> Self {
        Self { table: None, variants, outcomes: BTreeMap::new(), largest_peak_n: None }
    }
}
