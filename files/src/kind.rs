//! Recognises the kind of a file, so that a file of another kind gets one message instead of one for every
//! line.

use std::path::Path;

use feeler_problem::sort::sort_of;

use super::keys::ELEMENTS;
use super::keys::arm::URDF;
use super::keys::cell::ARM_FILE;
use super::keys::dataset::{COLUMNS, EXPERIMENTS};
use super::keys::sweep::AXES;
use super::problem::{FormatError, Problems};
use super::source::Sources;
use super::tree::Table;

/// The kinds of TOML file that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileKind {
    /// A machine, or a scenario based on one.
    Scenario,
    /// An arm with a URDF.
    Arm,
    /// A sweep over keys of a scenario.
    Sweep,
    /// Recorded series.
    Dataset,
}

impl FileKind {
    /// The kind of a table, with the key that shows it.
    fn of(table: &Table) -> Option<(Self, &str)> {
        let marks = [
            (AXES, Self::Sweep),
            (URDF.name, Self::Arm),
            (COLUMNS, Self::Dataset),
            (EXPERIMENTS, Self::Dataset),
            (ARM_FILE.name, Self::Scenario),
        ];
        let elements = ELEMENTS.iter().map(|element| (element.table, Self::Scenario));
        let found = marks.into_iter().chain(elements).find(|(mark, _)| table.contains_key(*mark));
        found.map(|(mark, kind)| (kind, mark))
    }

    fn noun(self) -> &'static str {
        match self {
            Self::Scenario => "a machine or scenario file",
            Self::Arm => "an arm file",
            Self::Sweep => "a sweep file",
            Self::Dataset => "a dataset file",
        }
    }

    /// The remedy for a file of this kind if another one is expected.
    fn remedy(self, wanted: Self) -> String {
        let command = match self {
            Self::Scenario => "run",
            Self::Arm => "reduce",
            Self::Sweep => "sweep",
            Self::Dataset => "diagnose",
        };
        let instead = match (self, wanted) {
            (Self::Arm, Self::Scenario) => ", and writes a machine file",
            (Self::Sweep, Self::Scenario) => "; name the scenario that it varies here",
            (Self::Dataset, Self::Scenario) => "; name the machine that it was recorded on here",
            (_, Self::Scenario) => "; name a machine or scenario file here",
            (_, Self::Arm) => "; name an arm file here: one with `urdf` and [joints]",
            (_, Self::Sweep) => "; name a sweep file here: one with `scenario` and [axes]",
            (_, Self::Dataset) => "; name a dataset here: a folder with dataset.toml in it",
        };
        format!("`feeler {command}` takes it{instead}")
    }
}

/// Rejects a file of another kind than expected.
pub(crate) fn refuse_other(table: &Table, wanted: FileKind, sources: &Sources) -> Result<(), FormatError> {
    let Some((found, mark)) = FileKind::of(table).filter(|(found, _)| *found != wanted) else {
        return Ok(());
    };
    // A sweep over a whole arm has its own remedy.
    if wanted == FileKind::Sweep && mark == ARM_FILE.name {
        return Ok(());
    }
    let origin = table.get(mark).map(|entry| entry.key.clone()).unwrap_or_default();
    let message = format!("this is {}, but {} is needed", found.noun(), wanted.noun());
    let mut problems = Problems::default();
    problems.add(&origin, mark, message, found.remedy(wanted));
    Err(problems.into_error(sources.clone()))
}

/// The kind of a file that is not TOML, and its remedy.
pub(crate) fn foreign(bytes: &[u8], path: &Path) -> Option<(&'static str, String)> {
    if bytes.starts_with(b"\xff\xfe") {
        return Some(("this is a text in UTF-16", "save it as UTF-8".into()));
    }
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let of_ending = OF_ENDINGS.into_iter().find(|(own, ..)| ending.as_deref() == Some(*own));
    if let Some((_, what, remedy)) = of_ending.filter(|_| !bytes.is_empty()) {
        return Some((what, remedy.into()));
    }
    if let Some(sort) = sort_of(bytes) {
        return Some((sort.what, if sort.remedy.is_empty() { RECORD } else { sort.remedy }.into()));
    }
    let text = std::str::from_utf8(bytes).ok()?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text).trim_start();
    if text.starts_with('<') {
        return Some(if text.contains("<xacro:") {
            ("this is a xacro", "expand it by `xacro FILE > robot.urdf`, and go on with that".into())
        } else if text.contains("<robot") {
            ("this is a URDF", of_urdf(path))
        } else if text.contains("<mujoco") {
            ("this is an MJCF model", "`feeler import LOG --mjcf FILE` makes a first machine of it".into())
        } else {
            ("this is XML", "name a TOML file: lines such as mass = 12.0 under [table.name]".into())
        });
    }
    if text.is_empty() {
        return Some(("this file is empty", "begin with a template: `feeler new --list` names them".into()));
    }
    if text.starts_with('{') {
        return Some(("this is JSON", AS_TOML.into()));
    }
    is_table_of_numbers(text).then(|| ("this is a table of numbers (CSV)", RECORD.into()))
}

/// File formats that the ending of the name shows more reliably than the first bytes.
const OF_ENDINGS: [(&str, &str, &str); 10] = [
    ("csv", "this is a table of numbers (CSV)", RECORD),
    ("tsv", "this is a table of numbers", RECORD),
    ("npz", "this is an archive of NumPy arrays (.npz)", RECORD),
    ("xlsx", "this is a spreadsheet", "save its sheet as CSV, and give that to `feeler import`"),
    ("ods", "this is a spreadsheet", "save its sheet as CSV, and give that to `feeler import`"),
    ("yaml", "this is YAML", AS_TOML),
    ("yml", "this is YAML", AS_TOML),
    ("py", "this is a Python program", AS_TOML),
    ("md", "this is a text of words", AS_TOML),
    ("pkl", "this is a Python pickle", "write its arrays with numpy.savez, and give that to `feeler import`"),
];
const AS_TOML: &str = "write it as TOML: `feeler new` gives a file to begin with";
/// The remedy for a record.
const RECORD: &str =
    "`feeler import` lists what it holds and makes a dataset of it, which `feeler diagnose` takes";

fn of_urdf(path: &Path) -> String {
    let name = path.file_name().map_or_else(|| "robot.urdf".into(), |name| name.to_string_lossy());
    format!("`feeler new arm --urdf {name} --out arm.toml` writes an arm file with its joints: name that")
}

/// Whether a text has a header and rows with as many numbers.
fn is_table_of_numbers(text: &str) -> bool {
    let mut lines = text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let (Some(header), Some(row)) = (lines.next(), lines.next()) else { return false };
    let mark = [',', ';', '\t'].into_iter().find(|mark| header.contains(*mark));
    mark.is_some_and(|mark| {
        !header.contains(['=', '[', ']'])
            && row.split(mark).count() == header.split(mark).count()
            && row.split(mark).all(|cell| cell.trim().replace(',', ".").parse::<f64>().is_ok())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_what_is_no_toml_is_named_in_one_line() {
        let path = Path::new("arms/robot.urdf");
        let what = |bytes: &[u8]| foreign(bytes, path).map(|(what, _)| what);
        for (bytes, expected) in [
            (&b"<?xml version=\"1.0\"?>\n<robot name=\"a\">"[..], "this is a URDF"),
            (b"<robot xmlns:xacro=\"x\"><xacro:arm/></robot>", "this is a xacro"),
            (b"<svg/>", "this is XML"),
            (b"{ \"bodies\": {} }", "this is JSON"),
            (b" \n", "this file is empty"),
            (b"\x89MCAP0\r\n....", "this is an MCAP log"),
            (b"SQLite format 3\0....", "this is a database, as ROS 2 bags are (.db3)"),
            (b"PAR1....", "this is a Parquet table"),
            (b"\x89PNG\r\n", "this is a picture"),
            (b"\x89HDF\r\n", "this is an HDF5 file (or a MATLAB 7.3 one)"),
            (b"MATLAB 5.0 MAT-file", "this is a MATLAB file"),
            (b"t_s,command_n\n0,1.5\n0.001,1.6\n", "this is a table of numbers (CSV)"),
            (b"t_s;command_n\n0;1,5\n", "this is a table of numbers (CSV)"),
        ] {
            assert_eq!(what(bytes), Some(expected));
        }
        for toml in ["[bodies.a]\nmass = 1\n", "# only a remark\n", "a = [1,2]\nb = 3\n", "name,x\n[a]\n"] {
            assert_eq!(what(toml.as_bytes()), None, "{toml}");
        }
        for (name, bytes, expected) in [
            ("a.npz", &b"PK\x03\x04"[..], "this is an archive of NumPy arrays (.npz)"),
            ("a.xlsx", b"PK\x03\x04", "this is a spreadsheet"),
            ("a.csv", b"type,q\nSTATE,\"[0.1, 0.2]\"\n", "this is a table of numbers (CSV)"),
            ("a.yaml", b"bodies:\n  a: 1\n", "this is YAML"),
            ("a.py", b"import numpy\n", "this is a Python program"),
            ("a.pkl", b"(lp0\n.", "this is a Python pickle"),
            ("a.mp4", b"\0\0\0\x20ftypisom", "this is a video"),
        ] {
            assert_eq!(foreign(bytes, Path::new(name)).map(|(what, _)| what), Some(expected));
        }
        let (_, remedy) = foreign(b"<robot/>", path).unwrap_or_default();
        assert!(remedy.contains("feeler new arm --urdf robot.urdf"), "{remedy}");
    }
}
