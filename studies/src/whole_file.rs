//! Writes files so that an existing file is always complete.

use std::fs::{self, File};
use std::hash::{BuildHasher, RandomState};
use std::io;
use std::path::Path;

/// Suffix of incomplete files.
const UNFINISHED: &str = ".tmp";

/// Writes a file completely or not at all, even if the process or the machine stops, or several processes
/// write the same file. The data go to another name beside it, are synchronised, then renamed; an existing
/// `path` is replaced. `write` returns the file when it has finished. `convert` converts a system error.
///
/// # Errors
/// Those of `write`, and `convert` of system errors; the new file is then removed.
pub fn write_whole<E>(
    path: &Path,
    convert: &dyn Fn(io::Error) -> E,
    write: impl FnOnce(File) -> Result<File, E>,
) -> Result<(), E> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    // Processes on several machines may have the same number.
    name.push(format!(".{:016x}{UNFINISHED}", RandomState::new().hash_one(std::process::id())));
    let temporary = path.with_file_name(name);
    let file = File::create(&temporary).map_err(convert)?;
    let written = write(file)
        .and_then(|file| file.sync_all().map_err(convert))
        .and_then(|()| fs::rename(&temporary, path).map_err(convert));
    if let Err(error) = written {
        // The incomplete file is useless; only the error of the writing matters.
        let _ = fs::remove_file(&temporary);
        return Err(error);
    }
    sync_folder(folder_of(path)).map_err(convert)
}

/// Removes temporary files that interrupted calls of [`write_whole`] for `path` have left. A call that is
/// still running fails then.
pub(crate) fn remove_unfinished(path: &Path) -> io::Result<()> {
    let begins = path.file_name().unwrap_or_default().to_string_lossy().into_owned() + ".";
    let is_left = |name: &str| {
        let number = name.strip_prefix(&begins).and_then(|rest| rest.strip_suffix(UNFINISHED));
        number.is_some_and(|number| number.len() == 16 && number.bytes().all(|byte| byte.is_ascii_hexdigit()))
    };
    for entry in fs::read_dir(folder_of(path))? {
        let entry = entry?;
        if entry.file_name().to_str().is_some_and(is_left) {
            match fs::remove_file(entry.path()) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
    }
    Ok(())
}

/// The folder of a file; the working folder for a bare name.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Makes a rename durable. Windows cannot synchronise folders, and does not need it.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder).and_then(|file| file.sync_all()) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn regress_what_a_killed_writer_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let names = [
            "results",
            "results.0123456789abcdef.tmp",
            "results.tmp",
            "other.0123456789abcdef.tmp",
            "results.0123456789abcdef.tmp.txt",
        ];
        for name in names {
            fs::write(folder.path().join(name), "text").unwrap();
        }
        remove_unfinished(&folder.path().join("results")).unwrap();
        for (i, name) in names.into_iter().enumerate() {
            assert_eq!(folder.path().join(name).exists(), i != 1, "{name}");
        }
    }

    #[test]
    fn truth_a_file_is_replaced_whole_or_left_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results");
        let put = |text: &str, fails: bool| {
            write_whole(&path, &|error| error.to_string(), |mut file| {
                file.write_all(text.as_bytes()).map_err(|error| error.to_string())?;
                if fails { Err("no room".to_owned()) } else { Ok(file) }
            })
        };
        assert_eq!(put("first", false), Ok(()));
        assert_eq!(put("second", true), Err("no room".to_owned()));
        assert_eq!(fs::read_to_string(&path).unwrap(), "first");
        assert_eq!(put("third", false), Ok(()));
        assert_eq!(fs::read_to_string(&path).unwrap(), "third");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
        assert!(write_whole(&folder.path().join("none/results"), &|error| error.kind(), Ok).is_err());
    }
}
