//! A sweep's folder: the plan it belongs to, chunks as they are done, and the table in the end.
//!
//! Every file is written under another name, synchronised and renamed, so that a file that is there is whole,
//! whenever the process is killed. Several processes may work in one folder: names until renamed are each
//! writer's own, and chunks that vanish while they are read mean that another has put the results together.

use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::error::SweepError;
use super::table::{Table, TableWriter};
use crate::whole_file::{remove_unfinished, write_whole};

/// What the results in a folder belong to.
const PLAN: &str = "plan.json";
const CHUNKS: &str = "chunks";
/// The results.
const TABLE: &str = "sweep.parquet";

/// A chunk: the pass it belongs to, and its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ChunkId {
    pub(super) pass: usize,
    pub(super) number: usize,
}

/// The folder of a sweep.
#[derive(Clone, Debug)]
pub(super) struct Store {
    folder: PathBuf,
}

impl Store {
    /// Takes a folder for a plan: makes it, or goes on with what it holds.
    pub(super) fn open(folder: &Path, plan: &str) -> Result<Self, SweepError> {
        let store = Self { folder: folder.into() };
        fs::create_dir_all(folder).map_err(SweepError::io(folder))?;
        let path = folder.join(PLAN);
        match fs::read_to_string(&path) {
            Ok(found) if found == plan => {}
            Ok(_) => return Err(SweepError::OtherSweep { folder: folder.into() }),
            Err(error) if error.kind() == ErrorKind::NotFound => put(&path, |mut file| {
                file.write_all(plan.as_bytes()).map_err(SweepError::io(&path))?;
                Ok(file)
            })?,
            Err(error) => return Err(SweepError::io(&path)(error)),
        }
        Ok(store)
    }

    /// An existing folder with the plan in it.
    pub(super) fn existing(folder: &Path) -> Result<(Self, String), SweepError> {
        let plan = fs::read_to_string(folder.join(PLAN))
            .map_err(|_| SweepError::NoSweep { folder: folder.into() })?;
        Ok((Self { folder: folder.into() }, plan))
    }

    /// Where the results are, in the end.
    pub(super) fn table(&self) -> PathBuf {
        self.folder.join(TABLE)
    }

    /// Whether the results are complete.
    pub(super) fn is_complete(&self) -> bool {
        self.table().exists()
    }

    fn chunk(&self, id: ChunkId) -> PathBuf {
        self.folder.join(CHUNKS).join(format!("{:02}-{:06}.parquet", id.pass, id.number))
    }

    pub(super) fn has(&self, id: ChunkId) -> bool {
        self.chunk(id).exists()
    }

    pub(super) fn read(&self, id: ChunkId) -> Result<Table, SweepError> {
        Table::read(&self.chunk(id))
    }

    pub(super) fn write(&self, id: ChunkId, table: Table) -> Result<(), SweepError> {
        let folder = self.folder.join(CHUNKS);
        fs::create_dir_all(&folder).map_err(SweepError::io(&folder))?;
        match Self::put_table(&self.chunk(id), std::iter::once(Ok(table))) {
            // The folder went away below the chunk, since another has put the results together.
            Err(_) if self.is_complete() => Ok(()),
            put => put,
        }
    }

    /// Puts the results together from all chunks in order, and removes these.
    pub(super) fn assemble(&self, chunks: &[(&Self, ChunkId)]) -> Result<(), SweepError> {
        let put = Self::put_table(&self.table(), chunks.iter().map(|(store, id)| store.read(*id)));
        match put {
            // Another was first, and has taken the chunks away.
            Err(_) if self.is_complete() => {}
            put => put?,
        }
        self.tidy()
    }

    /// Takes the results of another folder of the same sweep.
    pub(super) fn take_results(&self, other: &Self) -> Result<(), SweepError> {
        let source = other.table();
        let taken = put(&self.table(), |mut file| {
            let mut results = File::open(&source).map_err(SweepError::io(&source))?;
            std::io::copy(&mut results, &mut file).map_err(SweepError::io(&source))?;
            Ok(file)
        });
        match taken {
            Err(_) if self.is_complete() => {}
            taken => taken?,
        }
        self.tidy()
    }

    /// Removes what the results have made superfluous: the chunks, and what was begun of results and plan by
    /// a call that was killed. Whoever else puts the results together at this time finds them complete.
    pub(super) fn tidy(&self) -> Result<(), SweepError> {
        for name in [TABLE, PLAN] {
            remove_unfinished(&self.folder.join(name)).map_err(SweepError::io(&self.folder))?;
        }
        self.remove_chunks()
    }

    fn remove_chunks(&self) -> Result<(), SweepError> {
        let folder = self.folder.join(CHUNKS);
        match fs::remove_dir_all(&folder) {
            // Others remove them, or write one that comes too late, at the same time.
            Err(error) if !matches!(error.kind(), ErrorKind::NotFound | ErrorKind::DirectoryNotEmpty) => {
                Err(SweepError::io(&folder)(error))
            }
            _ => Ok(()),
        }
    }

    fn put_table(
        path: &Path,
        mut tables: impl Iterator<Item = Result<Table, SweepError>>,
    ) -> Result<(), SweepError> {
        let Some(first) = tables.next().transpose()? else { return Ok(()) };
        put(path, |file| {
            let mut writer = TableWriter::new(file, &first).map_err(SweepError::parquet(path))?;
            writer.add(first).map_err(SweepError::parquet(path))?;
            for table in tables {
                writer.add(table?).map_err(SweepError::parquet(path))?;
            }
            writer.finish().map_err(SweepError::parquet(path))
        })
    }
}

/// Writes a file whole or not at all.
fn put(path: &Path, write: impl FnOnce(File) -> Result<File, SweepError>) -> Result<(), SweepError> {
    write_whole(path, &|error| SweepError::io(path)(error), write)
}
