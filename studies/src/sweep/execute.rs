//! Runs the variants of one pass, chunk by chunk over the threads of the current pool.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use rayon::prelude::*;

use super::error::SweepError;
use super::points::Points;
use super::row::{VariantRow, table};
use super::shard::Shard;
use super::store::{ChunkId, Store};
use super::{Counters, Sweep, chunk_ids, chunks};
use crate::run::{self, Measured, PreparedRun, RunError, measure, write_parquet};
use feeler_files::Setting;

/// Number of variants that are prepared together, so that those of one structure can run side by side.
const BLOCK: usize = 64;
/// Folder of variants' traces, if these are kept.
const TRACES: &str = "traces";

impl Sweep {
    /// Runs the missing part of a pass, and returns its chunks. `first` is the number of its first variant.
    #[expect(
        clippy::too_many_arguments,
        reason = "each is what it says, and a struct for one call would only rename them"
    )]
    pub(super) fn pass(
        &self,
        points: &Points<'_>,
        pass: usize,
        first: u64,
        shard: Option<Shard>,
        folder: &Path,
        store: &Store,
        counters: &Counters<'_>,
    ) -> Result<Vec<ChunkId>, SweepError> {
        let ids = chunk_ids(pass, points.count());
        let mut missing = Vec::new();
        for (id, (start, count)) in ids.iter().zip(chunks(points.count())) {
            if shard.is_some_and(|shard| !shard.has(id.number)) {
                continue;
            }
            counters.add(&counters.total, count);
            if store.has(*id) {
                counters.add(&counters.found, count);
            } else {
                missing.push((*id, start, count));
            }
        }
        missing.par_iter().try_for_each(|&(id, start, count)| {
            let variants: Vec<u64> = (start..start + count).collect();
            let rows: Vec<Vec<VariantRow>> = (variants.par_chunks(BLOCK))
                .map(|block| {
                    let rows = self.block(points, first, block, folder);
                    counters.add(&counters.done, block.len() as u64);
                    rows
                })
                .collect();
            store.write(id, table(&self.file, &rows.concat()))
        })?;
        Ok(ids)
    }

    fn block(&self, points: &Points<'_>, first: u64, indices: &[u64], folder: &Path) -> Vec<VariantRow> {
        let settings: Vec<Vec<Setting>> = indices.iter().map(|&i| points.settings(i)).collect();
        let mut candidates = Vec::new();
        let refused: Vec<Option<String>> = (settings.iter())
            .map(|settings| self.candidate(settings).map(|candidate| candidates.push(candidate)).err())
            .collect();
        let mut measured = self.measured(&candidates).into_iter();
        let rows = indices.iter().zip(settings).zip(refused).map(|((&index, settings), refused)| {
            let variant = first + index;
            let result = match refused {
                Some(error) => Err(error),
                None => measured.next().unwrap_or_else(|| Err("there is no result".into())),
            };
            let result =
                result.and_then(|measured| self.keep_trace(&settings, variant, folder).map(|()| measured));
            VariantRow { variant, settings, result }
        });
        rows.collect()
    }

    fn candidate(&self, settings: &[Setting]) -> Result<PreparedRun, String> {
        let keyed = self.file.axes.keys().map(String::as_str).zip(settings.iter().cloned());
        let document = self.document.with(keyed).map_err(|error| {
            let problems: Vec<String> = error
                .problems
                .iter()
                .map(|problem| format!("{}: {}", problem.key, problem.message))
                .collect();
            problems.join("; ")
        })?;
        PreparedRun::new(document.scenario).map_err(|error| error.to_string())
    }

    /// Measures candidates side by side; if one of them makes the computation fail, each separately.
    fn measured(&self, candidates: &[PreparedRun]) -> Vec<Result<Measured, String>> {
        let tail = self.file.keep.tail;
        let guarded =
            |candidates: &[PreparedRun]| catch_unwind(AssertUnwindSafe(|| measure(candidates, tail)));
        let as_text = |result: Result<Measured, RunError>| result.map_err(|error| error.to_string());
        let alone = |candidate: &PreparedRun| {
            let result = guarded(std::slice::from_ref(candidate)).ok().and_then(|mut results| results.pop());
            result.map_or_else(|| Err("the run ended in an internal error".into()), as_text)
        };
        match guarded(candidates) {
            Ok(results) => results.into_iter().map(as_text).collect(),
            Err(_) => candidates.iter().map(alone).collect(),
        }
    }

    fn keep_trace(&self, settings: &[Setting], variant: u64, folder: &Path) -> Result<(), String> {
        if !self.file.keep.traces {
            return Ok(());
        }
        let keyed = self.file.axes.keys().map(String::as_str).zip(settings.iter().cloned());
        let document = self.document.with(keyed).map_err(|error| error.to_string())?;
        let result = run::run(&document.scenario, &mut |_| {}).map_err(|error| error.to_string())?;
        let folder = folder.join(TRACES);
        std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let path = folder.join(format!("{variant:06}.parquet"));
        let temporary = folder.join(format!("{variant:06}.parquet.tmp"));
        write_parquet(&result.trace, &[], &temporary).map_err(|error| error.to_string())?;
        std::fs::rename(&temporary, &path).map_err(|error| format!("{}: {error}", path.display()))
    }
}
