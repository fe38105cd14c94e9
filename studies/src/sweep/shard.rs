//! A sweep over several machines: each computes a part of the chunks, and the parts are combined.

use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use thiserror::Error;

use super::chunk_ids;
use feeler_problem::Remedy;

use super::error::SweepError;
use super::store::{ChunkId, Store};

/// Part `index` of `count`, both from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

/// Why a text is not a shard.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("`{text}` is not a shard K/N with K from 1 to N, as in 2/8")]
pub struct ParseShardError {
    pub text: String,
}

impl Remedy for ParseShardError {
    fn remedy(&self) -> Cow<'_, str> {
        "write which part of how many, as in 2/8".into()
    }
}

impl Shard {
    /// Whether there are other shards.
    pub(super) fn is_part(self) -> bool {
        self.count > 1
    }

    /// Whether a chunk belongs to this shard. Chunks are assigned in turn, so that slow parts of a map are
    /// shared.
    pub(super) fn has(self, chunk: usize) -> bool {
        chunk % self.count == self.index - 1
    }
}

impl FromStr for Shard {
    type Err = ParseShardError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts =
            text.split_once('/').and_then(|(k, n)| Some((k.trim().parse().ok()?, n.trim().parse().ok()?)));
        match parts {
            Some((index, count)) if index >= 1 && index <= count => Ok(Self { index, count }),
            _ => Err(ParseShardError { text: text.into() }),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// Combines the shards of a sweep. `folders` contain them (several may share one folder, and a single
/// complete one is enough), `out` receives the results. Returns the table's path.
///
/// # Errors
/// [`SweepError::NoSweep`], [`SweepError::OtherSweep`] if the folders hold different sweeps,
/// [`SweepError::Incomplete`].
pub fn merge(folders: &[PathBuf], out: &Path) -> Result<PathBuf, SweepError> {
    let stores = folders.iter().map(|folder| Store::existing(folder)).collect::<Result<Vec<_>, _>>()?;
    let Some((_, plan)) = stores.first() else { return Err(SweepError::NoSweep { folder: out.into() }) };
    if let Some(i) = stores.iter().position(|(_, other)| other != plan) {
        return Err(SweepError::OtherSweep { folder: folders[i].clone() });
    }
    let target = Store::open(out, plan)?;
    if target.is_complete() {
        return Ok(target.table());
    }
    if let Some((finished, _)) = stores.iter().find(|(store, _)| store.is_complete()) {
        target.take_results(finished)?;
        return Ok(target.table());
    }
    let variants =
        super::planned_variants(plan).ok_or_else(|| SweepError::NoSweep { folder: folders[0].clone() })?;
    let ids = chunk_ids(0, variants);
    let holder = |id: &ChunkId| {
        stores.iter().map(|(store, _)| store).find(|store| store.has(*id)).map(|store| (store, *id))
    };
    let found: Vec<_> = ids.iter().filter_map(holder).collect();
    if found.len() < ids.len() {
        let first = ids.iter().position(|id| holder(id).is_none()).unwrap_or(0);
        return Err(SweepError::Incomplete { missing: ids.len() - found.len(), chunks: ids.len(), first });
    }
    target.assemble(&found)?;
    Ok(target.table())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = ["3/2", "two"].map(|text| text.parse::<Shard>().unwrap_err());
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("shard.rs")),
            Vec::<String>::new()
        );
    }
}
