//! Where results go unless a folder is named.

use std::fs;
use std::hash::{BuildHasher, RandomState};
use std::path::{Path, PathBuf};

use crate::failure::BadInput;

/// Results go under this folder unless another is named.
const RESULTS: &str = "out";

/// `out/NAME` for what is called `name`.
pub(crate) fn folder(name: &str, otherwise: &str) -> PathBuf {
    Path::new(RESULTS).join(safe_name(name, otherwise))
}

/// A name that every file system takes and that leads nowhere else; `otherwise` where nothing of it is left.
pub(crate) fn safe_name(name: &str, otherwise: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let name: String = name.chars().map(safe).collect();
    let name = name.trim_matches('.');
    if name.is_empty() { otherwise } else { name }.to_owned()
}

/// Writes a file whole or not at all, so that several processes may write the same one.
pub(crate) fn put(path: &Path, content: &[u8]) -> anyhow::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    // Processes of several machines may have the same number.
    name.push(format!(".{:016x}.tmp", RandomState::new().hash_one(std::process::id())));
    let temporary = path.with_file_name(name);
    fs::write(&temporary, content).and_then(|()| fs::rename(&temporary, path)).map_err(|error| {
        // What is left of it is of no use; that the writing failed is what matters.
        let _ = fs::remove_file(&temporary);
        BadInput::unwritable(path, &error)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_name_stays_within_the_folder_of_results() {
        for (name, expected) in
            [("two masses", "two-masses"), ("../../etc", "-..-etc"), ("...", "run"), ("", "run"), ("Prüfstand_1.5", "Prüfstand_1.5")]
        {
            assert_eq!(folder(name, "run"), Path::new(RESULTS).join(expected));
        }
    }
}
