//! Files and folders that cannot be written.

use std::io::{Error, ErrorKind};
use std::path::Path;

use feeler_problem::Problem;

/// The mistake and the remedy for a file or folder that cannot be written.
pub fn unwritable(path: &Path, source: &Error) -> Problem {
    let file = path
        .ancestors()
        .find(|part| part.is_file())
        .filter(|file| *file != path || source.kind() == ErrorKind::AlreadyExists);
    if let Some(file) = file {
        let message = format!("cannot write {}: {} is a file, not a folder", path.display(), file.display());
        return Problem::new("", message, "name another folder with --out");
    }
    let remedy = if matches!(source.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded) {
        "make room there, or name another place with --out; a sweep goes on where it was"
    } else {
        "name another place with --out, or make this one writable"
    };
    Problem::new("", format!("cannot write {}: {source}", path.display()), remedy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_full_disk_has_a_remedy() {
        let full = Error::from(ErrorKind::StorageFull);
        let problem = unwritable(Path::new("out/sweep.parquet"), &full);
        assert!(problem.message.starts_with("cannot write out/sweep.parquet"), "{problem}");
        assert!(problem.remedy.starts_with("make room there"), "{problem}");
    }
}
