//! A sweep's folder: its plan, completed chunks, and the final table.
//!
//! Every file is written under another name, synchronised and renamed, so that an existing file is complete
//! even if the process is killed. Several processes may work in one folder: each has its own temporary names.
//! A chunk that disappears while it is read means that another process has assembled the results.

use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::error::SweepError;
use super::table::{SweepTable, TableWriter};
use crate::whole_file::{remove_unfinished, write_whole};

/// The plan that identifies the results in a folder.
const PLAN: &str = "plan.json";
const CHUNKS: &str = "chunks";
/// The results.
const TABLE: &str = "sweep.parquet";

/// A chunk: its pass and its number.
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
    /// Opens a folder for a plan: creates it, or continues with its contents.
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

    /// Path of the final results.
    pub(super) fn table(&self) -> PathBuf {
        self.folder.join(TABLE)
    }

    pub(super) fn is_complete(&self) -> bool {
        self.table().exists()
    }

    fn chunk(&self, id: ChunkId) -> PathBuf {
        self.folder.join(CHUNKS).join(format!("{:02}-{:06}.parquet", id.pass, id.number))
    }

    pub(super) fn has(&self, id: ChunkId) -> bool {
        self.chunk(id).exists()
    }

    pub(super) fn read(&self, id: ChunkId) -> Result<SweepTable, SweepError> {
        SweepTable::read(&self.chunk(id))
    }

    pub(super) fn write(&self, id: ChunkId, table: SweepTable) -> Result<(), SweepError> {
        let folder = self.folder.join(CHUNKS);
        fs::create_dir_all(&folder).map_err(SweepError::io(&folder))?;
        match Self::put_table(&self.chunk(id), std::iter::once(Ok(table))) {
            // The folder of the chunk was removed by another process that has assembled the results.
            Err(_) if self.is_complete() => Ok(()),
            put => put,
        }
    }

    /// Assembles the results from all chunks in order, and removes the chunks.
    pub(super) fn assemble(&self, chunks: &[(&Self, ChunkId)]) -> Result<(), SweepError> {
        let put = Self::put_table(&self.table(), chunks.iter().map(|(store, id)| store.read(*id)));
        match put {
            // Another process was first, and has removed the chunks.
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

    /// Removes files that the results have made superfluous: the chunks, and unfinished results and plans of
    /// a killed call. Another process that assembles the results at this time finds them complete.
    pub(super) fn tidy(&self) -> Result<(), SweepError> {
        for name in [TABLE, PLAN] {
            remove_unfinished(&self.folder.join(name)).map_err(SweepError::io(&self.folder))?;
        }
        self.remove_chunks()
    }

    fn remove_chunks(&self) -> Result<(), SweepError> {
        let folder = self.folder.join(CHUNKS);
        match fs::remove_dir_all(&folder) {
            // Other processes may remove them, or write a late one, at the same time.
            Err(error) if !matches!(error.kind(), ErrorKind::NotFound | ErrorKind::DirectoryNotEmpty) => {
                Err(SweepError::io(&folder)(error))
            }
            _ => Ok(()),
        }
    }

    fn put_table(
        path: &Path,
        mut tables: impl Iterator<Item = Result<SweepTable, SweepError>>,
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
