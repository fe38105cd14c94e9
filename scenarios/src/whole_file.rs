//! Writing files so that what stands under a name is always whole.

use std::fs::{self, File};
use std::hash::{BuildHasher, RandomState};
use std::io;
use std::path::Path;

/// Writes a file whole or not at all, whenever the process or the machine stops, and so that several processes may write the same one: under another name
/// beside it, synchronised, then renamed. What stands at `path` is replaced. `write` gives the file back when it is done with it; `told` is the error for
/// what the system says.
///
/// # Errors
/// Those of `write`, and `told` of the system's; of the new file nothing is left then.
pub fn write_whole<E>(path: &Path, told: &dyn Fn(io::Error) -> E, write: impl FnOnce(File) -> Result<File, E>) -> Result<(), E> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    // Processes of several machines may have the same number.
    name.push(format!(".{:016x}.tmp", RandomState::new().hash_one(std::process::id())));
    let temporary = path.with_file_name(name);
    let file = File::create(&temporary).map_err(told)?;
    let written = write(file).and_then(|file| file.sync_all().map_err(told)).and_then(|()| fs::rename(&temporary, path).map_err(told));
    if let Err(error) = written {
        // What is left of it is of no use; that the writing failed is what matters.
        let _ = fs::remove_file(&temporary);
        return Err(error);
    }
    sync_folder(path.parent().unwrap_or(Path::new(""))).map_err(told)
}

/// Makes a rename last. Windows cannot synchronise folders, and needs not.
fn sync_folder(folder: &Path) -> io::Result<()> {
    // The parent of a bare name is the folder at work.
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    if cfg!(unix) { File::open(folder).and_then(|file| file.sync_all()) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

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
