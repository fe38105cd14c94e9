//! Logs of the writers that robots use, compared bit for bit with their input.
//!
//! `write_logs.py` generates them. Without Python and its packages the test reports that and checks nothing.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use feeler_logs::{Run, Table, sources};
use serde_json::Value;

/// Python with the packages of `write_logs.py`: that of `FEELER_PYTHON`, else `python3`.
fn python() -> Option<String> {
    let name = std::env::var("FEELER_PYTHON").unwrap_or_else(|_| "python3".into());
    let imports = "import mcap, mcap_ros2, rosbags, pyarrow, numpy";
    let works = Command::new(&name).args(["-c", imports]).output().is_ok_and(|done| done.status.success());
    works.then_some(name)
}

fn runs(path: &Path) -> Vec<Run> {
    let found = sources(&[path]).unwrap_or_else(|error| panic!("{error}"));
    found.iter().flat_map(|source| source.read().unwrap_or_else(|error| panic!("{error}"))).collect()
}

fn bits(value: &Value) -> Vec<u64> {
    value.as_array().into_iter().flatten().filter_map(Value::as_u64).collect()
}

/// Columns with their numbers, by name: all expected ones, and no others.
fn assert_same(file: &str, table: &Table, expected: &Value) {
    let columns = expected["columns"].as_object().expect("columns");
    let mut names: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
    // A column of texts has no numbers.
    names.retain(|name| table.columns.iter().any(|column| column.name == *name && column.present() > 0));
    names.sort_unstable();
    let mut wanted: Vec<&str> = columns.keys().map(String::as_str).collect();
    wanted.sort_unstable();
    assert_eq!(names, wanted, "{file} {}", table.name);
    for (name, values) in columns {
        let column = table.columns.iter().find(|column| column.name == *name).expect("it is there");
        let found: Vec<u64> = column.values.iter().map(|x| x.to_bits()).collect();
        assert_eq!(found, bits(values), "{file} {} {name}", table.name);
    }
    if let Some(times) = expected.get("times_s") {
        let found: Vec<u64> = table.times_s.iter().map(|t| t.to_bits()).collect();
        assert_eq!(found, bits(times), "{file}: times");
    } else {
        let clock = table.clock.as_ref().expect("a clock");
        assert_eq!(table.times_s.len(), bits(&expected["times_ns"]).len());
        // The stamps are 2.5 ms apart: the file's own first one is zero.
        let found = table.times_s.iter().enumerate();
        let off = found.map(|(k, t)| (t - k as f64 * 0.0025).abs()).fold(0.0, f64::max);
        assert!(off < 2e-6, "{file} {}: {off} by {}", table.name, clock.column);
    }
}

#[test]
fn reference_logs_of_real_writers_are_read_to_the_last_bit() {
    let Some(python) = python() else {
        let _ = writeln!(
            std::io::stderr(),
            "skipped: Python with mcap, mcap-ros2-support, rosbags, pyarrow and numpy is absent"
        );
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/write_logs.py");
    let done = Command::new(python).arg(script).arg(folder.path()).output().expect("it runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let text = std::fs::read_to_string(folder.path().join("expected.json")).expect("it was written");
    let expected: Value = serde_json::from_str(&text).expect("JSON");
    let mut held = 0;
    for (file, tables) in expected.as_object().expect("a table") {
        let runs = runs(&folder.path().join(file));
        for (name, table) in tables.as_object().expect("a table") {
            let found = runs.iter().flat_map(|run| run.tables.iter().map(move |table| (run, table)));
            let found =
                found.filter(|(run, table)| name.is_empty() || table.name == *name || run.name == *name);
            let found: Vec<&Table> = found.map(|(_, table)| table).collect();
            assert_eq!(found.len(), 1, "{file}: {name}");
            assert_same(file, found[0], table);
            held += 1;
        }
    }
    // Seven topics of four MCAP logs and ten bags, some of them without definitions; eleven tables of arrays.
    assert_eq!(held, 14 * 7 + 11, "tables that were compared");
}
