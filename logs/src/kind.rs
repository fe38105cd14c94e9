//! The kind of a file, from its first bytes.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::LogError;

/// Formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text with columns.
    Csv,
    /// An MCAP log.
    Mcap,
    /// A ROS 2 bag in SQLite.
    Sqlite,
    /// A Parquet table.
    Parquet,
    /// One NumPy array.
    Npy,
    /// An archive of NumPy arrays.
    Npz,
}

impl Format {
    /// The name of the format in a sentence.
    pub fn noun(self) -> &'static str {
        match self {
            Self::Csv => "CSV",
            Self::Mcap => "MCAP",
            Self::Sqlite => "ROS 2 bag",
            Self::Parquet => "Parquet",
            Self::Npy => "npy",
            Self::Npz => "npz",
        }
    }
}

/// Formats by their first bytes.
const READ: [(&[u8], Format); 5] = [
    (b"\x89MCAP0\r\n", Format::Mcap),
    (b"SQLite format 3\0", Format::Sqlite),
    (b"PAR1", Format::Parquet),
    (b"\x93NUMPY", Format::Npy),
    (b"PK\x03\x04", Format::Npz),
];

const UNPACK: &str = "unpack it, and name the log in it";
const TO_NPZ: &str = "write its arrays with numpy.savez (the Python package of Feeler reads it as well)";

/// First bytes of files that are not logs, or of unsupported logs.
const REFUSED: [(&[u8], &str, &str); 12] = [
    (
        b"#ROSBAG",
        "this is a ROS 1 bag",
        "convert it: `pip install rosbags`, then `rosbags-convert --src FILE --dst bag`",
    ),
    (b"\x89HDF\r\n", "this is an HDF5 file (or a MATLAB 7.3 one)", TO_NPZ),
    (b"MATLAB 5.0", "this is a MATLAB file", TO_NPZ),
    (
        b"MDF     ",
        "this is an MDF measurement (.mf4)",
        "convert it to CSV or Parquet, as with the Python package asammdf",
    ),
    (b"ULog\x01", "this is a PX4 ULog", "convert it to CSV: `pip install pyulog`, then `ulog2csv FILE`"),
    (
        b"ARROW1",
        "this is an Arrow or Feather file",
        "write it as Parquet: pyarrow.parquet.write_table(pyarrow.feather.read_table(FILE), NAME)",
    ),
    (b"\x28\xb5\x2f\xfd", "this is compressed by zstd", "unpack it: `zstd -d FILE`"),
    (b"\x1f\x8b", "this is compressed by gzip", "unpack it: `gunzip FILE`"),
    (b"BZh", "this is compressed by bzip2", "unpack it: `bunzip2 FILE`"),
    (b"\xfd7zXZ", "this is compressed by xz", "unpack it: `unxz FILE`"),
    (b"%PDF", "this is a PDF", "name the table that it was printed from"),
    (b"\x89PNG", "this is a picture", "name the numbers that it was drawn from"),
];

/// The format of a file; an error names its actual kind.
pub(crate) fn of(path: &Path) -> Result<Format, LogError> {
    let mut start = Vec::new();
    let file = File::open(path).map_err(LogError::open(path))?;
    file.take(512).read_to_end(&mut start).map_err(LogError::open(path))?;
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_ascii_lowercase();
    if let Some((_, format)) = READ.into_iter().find(|(magic, _)| start.starts_with(magic)) {
        if format == Format::Npz && ending != "npz" {
            return Err(LogError::other(path, "this is a zip archive", UNPACK));
        }
        return Ok(format);
    }
    if let Some((_, what, remedy)) = REFUSED.into_iter().find(|(magic, ..)| start.starts_with(magic)) {
        return Err(LogError::other(path, what, remedy));
    }
    let expected = match ending.as_str() {
        "mcap" => Some("an MCAP log"),
        "db3" | "sqlite3" => Some("a ROS 2 bag"),
        "parquet" => Some("a Parquet table"),
        "npy" | "npz" => Some("a NumPy array"),
        _ => None,
    };
    if let Some(expected) = expected {
        let what = format!("its first bytes are not those of {expected}");
        return Err(LogError::other(
            path,
            what,
            "copy it again: it is damaged, or has another file's ending",
        ));
    }
    refuse_text(path, &start, &ending)?;
    Ok(Format::Csv)
}

/// Rejects texts that are files of another kind.
fn refuse_text(path: &Path, start: &[u8], ending: &str) -> Result<(), LogError> {
    let text = String::from_utf8_lossy(start);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    if text.starts_with('<') {
        let (what, remedy) = match ending {
            "urdf" => ("this is a URDF", format!("name the log first, and this by `--urdf {name}`")),
            _ if text.contains("<mujoco") => {
                ("this is an MJCF model", format!("name the log first, and this by `--mjcf {name}`"))
            }
            _ if text.contains("<robot") => {
                ("this is a URDF", format!("name the log first, and this by `--urdf {name}`"))
            }
            _ => ("this is XML", "name a log: MCAP, a ROS 2 bag, Parquet, npz, npy or CSV".to_owned()),
        };
        return Err(LogError::other(path, what, remedy));
    }
    if ending == "toml" {
        let remedy = "`feeler check` says what it is; name the log that was recorded";
        return Err(LogError::other(path, "this is a TOML file of Feeler", remedy));
    }
    if text.starts_with('{') {
        let remedy = "write a row of numbers for each instant, as CSV, or JSON messages in an MCAP log";
        return Err(LogError::other(path, "this is JSON", remedy));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_files_of_another_sort_are_named_with_what_to_do() {
        let folder = tempfile::tempdir().expect("a folder");
        let of = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).expect("written");
            of(&path)
        };
        for (name, bytes, what, remedy) in [
            ("a.bag", &b"#ROSBAG V2.0\n"[..], "ROS 1 bag", "rosbags-convert"),
            ("a.mat", b"MATLAB 5.0 MAT-file", "MATLAB", "savez"),
            ("a.h5", b"\x89HDF\r\n\x1a\n", "HDF5", "savez"),
            ("r.urdf", b"<?xml?><robot name='r'>", "URDF", "--urdf r.urdf"),
            ("r.xml", b"<mujoco model='r'>", "MJCF", "--mjcf r.xml"),
            ("m.toml", b"[bodies.a]", "TOML", "feeler check"),
            ("a.json", b"{\"a\": 1}", "JSON", "CSV"),
            ("a.mcap", b"hello", "first bytes", "copy it again"),
            ("a.zip", b"PK\x03\x04", "zip", "unpack"),
            ("a.csv.gz", b"\x1f\x8b..", "gzip", "gunzip"),
        ] {
            let error = of(name, bytes).expect_err("refused");
            assert!(error.to_string().contains(what), "{error}");
            assert!(feeler_problem::Remedy::remedy(&error).contains(remedy), "{name}");
        }
        assert_eq!(of("a.txt", b"1 2 3\n").expect("read"), Format::Csv);
        assert_eq!(of("a.log", b"\x89MCAP0\r\n").expect("read"), Format::Mcap);
    }
}
