//! File formats by their first bytes, so that every command names a wrong file in the same way.

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sort {
    /// Its first bytes.
    pub begins: &'static [u8],
    /// The format in a sentence.
    pub what: &'static str,
    /// How to convert the file into one that Feeler reads; empty for a log, which `feeler import` reads.
    pub remedy: &'static str,
}

const fn log(begins: &'static [u8], what: &'static str) -> Sort {
    Sort { begins, what, remedy: "" }
}

const fn other(begins: &'static [u8], what: &'static str, remedy: &'static str) -> Sort {
    Sort { begins, what, remedy }
}

const fn pickle(begins: &'static [u8]) -> Sort {
    other(begins, "this is a Python pickle", TO_NPZ)
}

/// An MCAP log.
pub const MCAP: Sort = log(b"\x89MCAP0\r\n", "this is an MCAP log");
/// A ROS 2 bag.
pub const SQLITE: Sort = log(b"SQLite format 3\0", "this is a database, as ROS 2 bags are (.db3)");
/// A Parquet table.
pub const PARQUET: Sort = log(b"PAR1", "this is a Parquet table");
/// One array of NumPy.
pub const NPY: Sort = log(b"\x93NUMPY", "this is a NumPy array (.npy)");
/// An archive; of arrays if its name says so.
pub const ZIP: Sort = other(
    b"PK\x03\x04",
    "this is a zip archive",
    "unpack it, and name the file in it; an .npz goes to `feeler import` as it is",
);

/// Any file compressed by `zstd`.
pub const ZSTD: Sort = other(b"\x28\xb5\x2f\xfd", "this is compressed by zstd", "unpack it: `zstd -d FILE`");

const TO_NPZ: &str = "write its arrays with numpy.savez, and give that to `feeler import`";
const PICTURE: &str = "this is a picture";
const DRAWN: &str = "name the file that it was drawn from";

/// Every format with its own first bytes.
pub const ALL: [Sort; 30] = [
    MCAP,
    SQLITE,
    PARQUET,
    NPY,
    ZIP,
    other(
        b"#ROSBAG",
        "this is a ROS 1 bag",
        "convert it: `pip install rosbags`, then `rosbags-convert --src FILE --dst bag`",
    ),
    other(b"\x89HDF\r\n", "this is an HDF5 file (or a MATLAB 7.3 one)", TO_NPZ),
    other(b"MATLAB 5.0", "this is a MATLAB file", TO_NPZ),
    other(
        b"MDF     ",
        "this is an MDF measurement (.mf4)",
        "convert it to CSV or Parquet, as with the Python package asammdf",
    ),
    other(b"ULog\x01", "this is a PX4 ULog", "convert it to CSV: `pip install pyulog`, then `ulog2csv FILE`"),
    other(
        b"ARROW1",
        "this is an Arrow or Feather file",
        "write it as Parquet: pyarrow.parquet.write_table(pyarrow.feather.read_table(FILE), NAME)",
    ),
    ZSTD,
    other(b"\x1f\x8b", "this is compressed by gzip", "unpack it: `gunzip FILE`"),
    other(b"BZh", "this is compressed by bzip2", "unpack it: `bunzip2 FILE`"),
    other(b"\xfd7zXZ", "this is compressed by xz", "unpack it: `unxz FILE`"),
    pickle(b"\x80\x02"),
    pickle(b"\x80\x03"),
    pickle(b"\x80\x04"),
    pickle(b"\x80\x05"),
    other(b"TDSm", "this is a LabVIEW file (.tdms)", "convert it to CSV, as with the Python package npTDMS"),
    other(
        b"RRF2",
        "this is a Rerun recording (.rrd)",
        "write its columns as Parquet, with the package rerun-sdk",
    ),
    other(b"\xd0\xcf\x11\xe0", "this is a file of an office program", "save its table as CSV"),
    other(b"%PDF", "this is a PDF", DRAWN),
    other(b"\x89PNG", PICTURE, DRAWN),
    other(b"\xff\xd8\xff", PICTURE, DRAWN),
    other(b"GIF8", PICTURE, DRAWN),
    other(b"\x7fELF", "this is a program", "name a log or a text file here"),
    other(b"\x1aE\xdf\xa3", VIDEO.what, VIDEO.remedy),
    other(b"RIFF", "this is a video or a sound", VIDEO.remedy),
    other(b"7z\xbc\xaf", "this is a 7-Zip archive", "unpack it, and name the file in it"),
];

/// A video whose first bytes are the length of its first part.
const VIDEO: Sort = other(b"ftyp", "this is a video", "name the log of numbers that was recorded beside it");

/// The format of a file that begins with these bytes.
pub fn sort_of(bytes: &[u8]) -> Option<Sort> {
    let is_video = bytes.get(4..8) == Some(VIDEO.begins);
    ALL.into_iter().find(|sort| bytes.starts_with(sort.begins)).or(is_video.then_some(VIDEO))
}
