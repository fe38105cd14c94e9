//! Reading files of bounded size.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

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

/// The same as a text.
pub(super) fn read_text(path: &Path, most: u64) -> Result<String> {
    text_of(read_bytes(path, most)?)
}

/// Bytes as a text.
pub(super) fn text_of(bytes: Vec<u8>) -> Result<String> {
    String::from_utf8(bytes).map_err(|error| {
        let (bytes, at) = (error.as_bytes(), error.utf8_error().valid_up_to());
        let line = bytes[..at].split(|byte| *byte == b'\n').count();
        Error::new(ErrorKind::InvalidData, format!("line {line}: byte {at} is not UTF-8"))
    })
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
}
