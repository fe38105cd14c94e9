//! The kind of a file, from its first bytes.

use std::path::Path;

use feeler_problem::sort::{self, Sort};

use crate::error::LogError;
use crate::packed;

/// Formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text with columns.
    Csv,
    Mcap,
    /// A ROS 2 bag in SQLite.
    Sqlite,
    Parquet,
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
const READ: [(Sort, Format); 5] = [
    (sort::MCAP, Format::Mcap),
    (sort::SQLITE, Format::Sqlite),
    (sort::PARQUET, Format::Parquet),
    (sort::NPY, Format::Npy),
    (sort::ZIP, Format::Npz),
];

/// Files that are archives inside, by their endings.
const ZIPPED: [(&str, &str, &str); 4] = [
    ("xlsx", "this is a spreadsheet", "save its sheet as CSV"),
    ("ods", "this is a spreadsheet", "save its sheet as CSV"),
    ("pt", "this is a file of PyTorch", "write its tensors with numpy.savez"),
    ("pth", "this is a file of PyTorch", "write its tensors with numpy.savez"),
];
/// How a web page begins.
const WEB: [&str; 2] = ["<html", "<!doctype html"];
/// Place of the mark of a tar archive.
const TAR_AT: usize = 257;

/// The format of a file; an error names its actual kind.
pub(crate) fn of(path: &Path) -> Result<Format, LogError> {
    let (start, sort) = packed::start(path)?;
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_ascii_lowercase();
    if let Some(found) = sort {
        let read = READ.into_iter().find(|(sort, _)| *sort == found).map(|(_, format)| format);
        let read = read.filter(|format| *format != Format::Npz || ending == "npz");
        if let Some((_, what, remedy)) = ZIPPED.into_iter().find(|(other, ..)| *other == ending) {
            return Err(LogError::other(path, what, remedy));
        }
        return read.ok_or_else(|| LogError::other(path, found.what, found.remedy));
    }
    if start.get(TAR_AT..).is_some_and(|rest| rest.starts_with(b"ustar")) {
        return Err(LogError::other(
            path,
            "this is a tar archive",
            "unpack it by `tar -xf`, and name what is in it",
        ));
    }
    let expected = match ending.as_str() {
        "mcap" => Some("an MCAP log"),
        "db3" | "sqlite3" => Some("a ROS 2 bag"),
        "parquet" => Some("a Parquet table"),
        "npy" | "npz" => Some("a NumPy array"),
        _ => None,
    };
    if let (Some(_), true) = (expected, start.is_empty()) {
        return Err(LogError::other(path, "it is empty", "record it again: nothing was written into it"));
    }
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
            _ if WEB.iter().any(|begins| text.to_ascii_lowercase().starts_with(begins)) => {
                ("this is a web page", "save what it shows as a file: its link names one".to_owned())
            }
            _ => ("this is XML", "name a log: MCAP, a ROS 2 bag, Parquet, npz, npy or CSV".to_owned()),
        };
        return Err(LogError::other(path, what, remedy));
    }
    if ending == "toml" {
        let remedy = "`feeler check` says what it is; name the log that was recorded";
        return Err(LogError::other(path, "this is a TOML file of Feeler, not a log", remedy));
    }
    let of_ending = match ending {
        "yaml" | "yml" => Some(("this is YAML", "name the bag that it describes, or another log")),
        // Those of the oldest protocol are text.
        "pkl" | "pickle" => Some(("this is a Python pickle", "write its arrays with numpy.savez")),
        "py" => Some(("this is a Python program", "name the log that it writes")),
        "obj" | "stl" | "ply" | "dae" => Some(("this is a mesh", "name a log of what moved")),
        _ => None,
    };
    if let Some((what, remedy)) = of_ending {
        return Err(LogError::other(path, what, remedy));
    }
    if text.starts_with('{') || text.starts_with("[{") || ending == "json" {
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
            ("a.mcap", b"", "empty", "record it again"),
            ("a.zip", b"PK\x03\x04", "zip", "unpack"),
            ("a.csv.gz", b"\x1f\x8b..", "gzip", "gunzip"),
            ("a.yaml", b"a: 1\n", "YAML", "log"),
            ("a.obj", b"v 1.0 2.0 3.0\n", "mesh", "log"),
            ("a.jpg", b"\xff\xd8\xff\xe0", "picture", "drawn"),
            ("a.pkl", b"\x80\x04\x95..", "pickle", "savez"),
            ("a.tdms", b"TDSm..", "LabVIEW", "CSV"),
            ("a.rrd", b"RRF2..", "Rerun", "Parquet"),
            ("a.xls", b"\xd0\xcf\x11\xe0..", "office", "CSV"),
            ("a.xlsx", b"PK\x03\x04", "spreadsheet", "CSV"),
            ("a.pt", b"PK\x03\x04", "PyTorch", "savez"),
            ("a.tar", &[&[b'a'; 257][..], b"ustar"].concat(), "tar", "tar -xf"),
            ("a.json", b"[{\"t\": 0}]", "JSON", "CSV"),
            ("a.html", b"<!DOCTYPE html>", "web page", "link"),
            ("a.pkl", b"(lp0\n.", "pickle", "savez"),
            ("a.mp4", b"\0\0\0\x20ftypisom", "video", "beside it"),
            ("a.mkv", b"\x1aE\xdf\xa3..", "video", "beside it"),
            ("a.avi", b"RIFF....AVI ", "video", "beside it"),
            ("a.7z", b"7z\xbc\xaf..", "7-Zip", "unpack"),
        ] {
            let error = of(name, bytes).expect_err("refused");
            assert!(error.to_string().contains(what), "{error}");
            assert!(feeler_problem::Remedy::remedy(&error).contains(remedy), "{name}");
        }
        assert_eq!(of("a.txt", b"1 2 3\n").expect("read"), Format::Csv);
        assert_eq!(of("a.log", b"\x89MCAP0\r\n").expect("read"), Format::Mcap);
    }
}
