//! Reading files of bounded size.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::{Path, PathBuf};

use feeler_plant::names::nearest;

/// The bytes of a file with at most `most` of them. Devices and pipes do not report their size, so the bytes
/// are counted.
pub(super) fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let found = File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if found as u64 > most {
        return Err(Error::new(ErrorKind::FileTooLarge, format!("it has more than {most} bytes")));
    }
    Ok(bytes)
}

pub(super) fn read_text(path: &Path, most: u64) -> Result<String> {
    text_of(read_bytes(path, most)?)
}

pub(super) fn text_of(bytes: Vec<u8>) -> Result<String> {
    if let Some(at) = bytes.iter().position(|byte| *byte == 0) {
        return Err(Error::new(ErrorKind::InvalidData, format!("byte {at} is zero: this is not text")));
    }
    String::from_utf8(bytes).map_err(|error| {
        let (bytes, at) = (error.as_bytes(), error.utf8_error().valid_up_to());
        let line = bytes[..at].split(|byte| *byte == b'\n').count();
        Error::new(ErrorKind::InvalidData, format!("line {line}: byte {at} is not UTF-8"))
    })
}

/// Advice for a file that does not exist. It names a file in the same folder with a similar name and the same
/// ending, or with the same name and another ending.
pub(super) fn remedy_of_missing(path: &Path) -> String {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let others: Vec<PathBuf> = (std::fs::read_dir(folder).into_iter().flatten().flatten())
        .filter(|entry| entry.path().is_file())
        .map(|entry| PathBuf::from(entry.file_name()))
        .collect();
    let kind = path.extension();
    let of_its_kind = || others.iter().filter(move |other| other.extension() == kind);
    let stem = |path: &Path| path.file_stem().and_then(OsStr::to_str).map(str::to_owned);
    let stems: Vec<String> = of_its_kind().filter_map(|other| stem(other)).collect();
    let near =
        stem(path).and_then(|wanted| nearest(&wanted, stems.iter().map(String::as_str)).map(str::to_owned));
    let found = near.and_then(|near| of_its_kind().find(|other| stem(other).as_ref() == Some(&near)));
    match found.or_else(|| others.iter().find(|other| other.file_stem() == path.file_stem())) {
        Some(other) => format!("did you mean `{}`?", path.with_file_name(other).display()),
        None => "name an existing file".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_no_more_is_read_than_allowed() {
        let path = std::env::temp_dir().join(format!("feeler-file-{}", std::process::id()));
        std::fs::write(&path, b"ab\ncd\xff").unwrap();
        assert_eq!(read_bytes(&path, 6).unwrap().len(), 6);
        assert_eq!(read_bytes(&path, 5).unwrap_err().to_string(), "it has more than 5 bytes");
        assert_eq!(read_text(&path, 6).unwrap_err().to_string(), "line 2: byte 5 is not UTF-8");
        std::fs::remove_file(&path).unwrap();
        #[cfg(unix)]
        assert!(read_bytes(Path::new("/dev/zero"), 1000).is_err());
    }

    #[test]
    fn truth_a_missing_file_is_taken_for_the_nearest_of_its_kind() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["axis.toml", "axes.csv", "sweep.toml"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let near = folder.path().join("axis.toml");
        let said = format!("did you mean `{}`?", near.display());
        assert_eq!(remedy_of_missing(&folder.path().join("axes.toml")), said);
        assert_eq!(remedy_of_missing(&folder.path().join("gripper.toml")), "name an existing file");
        let sweep = folder.path().join("sweep.toml");
        let said = format!("did you mean `{}`?", sweep.display());
        assert_eq!(remedy_of_missing(&folder.path().join("sweep.tml")), said);
    }
}
