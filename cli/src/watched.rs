//! Files that are watched for changes.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use feeler_files::Document;

/// Files, each with the time of its last change and its size; `None` for a missing file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Watched(Vec<(PathBuf, Option<(SystemTime, u64)>)>);

impl Watched {
    /// A single file in its present state.
    pub(crate) fn file(path: &Path) -> Self {
        Self(vec![(path.to_owned(), changed(path))])
    }

    /// A file and its base files in their present state.
    pub(crate) fn of(document: &Document) -> Self {
        Self(document.files().map(|path| (path.to_owned(), changed(path))).collect())
    }

    pub(crate) fn is_of(&self, document: &Document) -> bool {
        self.0.iter().map(|(path, _)| path.as_path()).eq(document.files())
    }

    /// The files in their present state.
    pub(crate) fn now(&self) -> Self {
        Self(self.0.iter().map(|(path, _)| (path.clone(), changed(path))).collect())
    }
}

/// Time and size of a file. Two changes within one tick of the file system's clock rarely leave the same
/// size.
fn changed(path: &Path) -> Option<(SystemTime, u64)> {
    let file = std::fs::metadata(path).ok()?;
    Some((file.modified().ok()?, file.len()))
}
