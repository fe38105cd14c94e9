//! Runs a scenario in many variants.
//!
//! Variants are numbered, and each is computed from its number. A sweep of any size therefore needs only the
//! memory of its present chunks. The results of a chunk are on disk before the next one starts, so a killed
//! sweep continues where it was. The final results depend neither on that nor on the number of threads or
//! shards. A variant that fails becomes a row with its error.

mod axes;
mod boundary;
mod contour;
mod cycles;
mod error;
mod execute;
mod permutation;
mod points;
mod refine;
mod row;
mod shard;
mod sobol;
mod store;
mod table;
mod theory;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use serde_json::json;

pub use axes::{DrawnAxis, Panels, share_between, shown};
pub(crate) use boundary::sampled_growth_per_s;
pub use boundary::{BoundaryLine, LinearLimits};
pub use error::SweepError;
pub use shard::{ParseShardError, Shard, merge};
pub(crate) use sobol::sobol;
pub use table::{SweepColumn, SweepTable};
pub use theory::{CyclesAt, MapTheory, Theory};

use feeler_files::{Document, SweepFile};
use points::Points;
use store::{ChunkId, Store};

/// Approximate number of chunks of a sweep: enough for many cores, and a killed sweep loses little.
const CHUNKS: u64 = 64;
/// Smallest and largest number of variants of a chunk.
const CHUNK: [u64; 2] = [crate::run::LANES as u64, 1024];
/// Version of the results. It changes whenever the same files would give other bytes.
const RESULTS_VERSION: u32 = 11;

/// A sweep ready to run.
#[derive(Clone, Debug)]
pub struct Sweep {
    pub file: SweepFile,
    pub document: Document,
    /// The files' texts, which identify the results.
    plan: String,
}

/// Settings of a call.
#[derive(Clone, Copy, Debug, Default)]
pub struct SweepOptions {
    /// Number of threads; `None` for one per processor.
    pub threads: Option<usize>,
    /// The part of the sweep to run; `None` for all of it.
    pub shard: Option<Shard>,
}

/// Progress of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SweepProgress {
    /// Variants done in this call.
    pub done: u64,
    /// Variants completed by an earlier call.
    pub found: u64,
    /// Number of variants of the sweep; for an adaptive sweep, of those known so far.
    pub total: u64,
}

/// Result of a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepResult {
    /// The table of results; `None` for one of several shards, until [`merge`] combines them.
    pub table: Option<PathBuf>,
    /// Numbers of variants: run by this call, found from earlier calls, and in total.
    pub progress: SweepProgress,
    /// Passes of an adaptive sweep, 1 for any other; `None` if an earlier call completed them.
    pub passes: Option<usize>,
}

impl Sweep {
    /// Reads and checks a sweep file and its scenario.
    ///
    /// # Errors
    /// Every mistake at once.
    pub fn load(path: &Path) -> Result<Self, SweepError> {
        let text = feeler_files::read_text(path)?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Checks `text` as the content of `file_name`, and its scenario.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn parse(text: &str, file_name: &str) -> Result<Self, SweepError> {
        let file = SweepFile::parse(text, file_name)?;
        let document = Document::load(&file.scenario)?;
        let scenario: Vec<&str> = document.texts().collect();
        let plan = json!({
            "version": RESULTS_VERSION,
            "variants": file.samples,
            "feeler": env!("CARGO_PKG_VERSION"),
            "sweep": text,
            "scenario": scenario,
        });
        Ok(Self { file, document, plan: plan.to_string() + "\n" })
    }

    /// Runs the sweep, or continues it, in `folder`.
    ///
    /// # Errors
    /// [`SweepError::OtherSweep`], [`SweepError::RefineShard`], and system errors of files and threads.
    pub fn run(
        &self,
        folder: &Path,
        options: SweepOptions,
        progress: &(dyn Fn(SweepProgress) + Sync),
    ) -> Result<SweepResult, SweepError> {
        if options.shard.is_some() && self.file.refine.is_some() {
            return Err(SweepError::RefineShard);
        }
        let store = Store::open(folder, &self.plan)?;
        if store.is_complete() {
            // A process that assembled the results may have ended before it removed the chunks.
            store.tidy()?;
            let found = SweepTable::count_rows(&store.table())? as u64;
            let progress = SweepProgress { done: 0, found, total: found };
            return Ok(SweepResult { table: Some(store.table()), progress, passes: None });
        }
        let threads = options.threads.unwrap_or(0);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|source| SweepError::Threads { source })?;
        let counters = Counters {
            done: AtomicU64::new(0),
            found: AtomicU64::new(0),
            total: AtomicU64::new(0),
            tell: progress,
        };
        let ran = pool.install(|| match self.file.refine {
            Some(refine) => self.run_refined(refine, folder, &store, &counters),
            None => self
                .pass(&Points::Plan(&self.file), 0, 0, options.shard, folder, &store, &counters)
                .map(|chunks| vec![chunks]),
        });
        let passes = match ran {
            // Another process has assembled the results and removed the chunks.
            Err(_) if store.is_complete() => Vec::new(),
            ran => ran?,
        };
        let (count, ids) = (passes.len(), passes.concat());
        // A shard does not know when the others have finished reading. [`merge`] combines their chunks.
        let is_part = options.shard.is_some_and(Shard::is_part);
        let table = if store.is_complete() {
            store.tidy()?;
            Some(store.table())
        } else if !is_part && ids.iter().all(|id| store.has(*id)) {
            store.assemble(&ids.iter().map(|id| (&store, *id)).collect::<Vec<_>>())?;
            Some(store.table())
        } else {
            None
        };
        Ok(SweepResult { table, progress: counters.now(), passes: Some(count).filter(|&passes| passes > 0) })
    }
}

/// Number of variants in a plan.
fn planned_variants(plan: &str) -> Option<u64> {
    serde_json::from_str::<serde_json::Value>(plan).ok()?.get("variants")?.as_u64()
}

/// Divides variants into chunks: the first variant of each, and its length.
fn chunks(variants: u64) -> impl ExactSizeIterator<Item = (u64, u64)> {
    let size = (variants / CHUNKS).clamp(CHUNK[0], CHUNK[1]).next_multiple_of(CHUNK[0]);
    let count = variants.div_ceil(size) as usize;
    (0..count).map(move |i| (i as u64 * size, size.min(variants - i as u64 * size)))
}

fn chunk_ids(pass: usize, variants: u64) -> Vec<ChunkId> {
    (0..chunks(variants).len()).map(|number| ChunkId { pass, number }).collect()
}

/// Counts completed variants, and reports progress.
struct Counters<'a> {
    done: AtomicU64,
    found: AtomicU64,
    total: AtomicU64,
    tell: &'a (dyn Fn(SweepProgress) + Sync),
}

impl Counters<'_> {
    fn add(&self, counter: &AtomicU64, variants: u64) {
        counter.fetch_add(variants, Ordering::Relaxed);
        (self.tell)(self.now());
    }

    fn now(&self) -> SweepProgress {
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        SweepProgress { done: of(&self.done), found: of(&self.found), total: of(&self.total) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_chunks_cover_every_variant_once() {
        for variants in [1, 7, 8, 9, 511, 4096, 100_003, 1_000_000] {
            let mut next = 0;
            for (first, count) in chunks(variants) {
                assert_eq!(first, next);
                assert!(count >= 1 && count <= CHUNK[1]);
                next += count;
            }
            assert_eq!(next, variants);
        }
        assert_eq!(chunks(4096).len(), 64);
    }
}
