//! The simulation against closed forms, other people's numbers and the paper.

mod checks;
mod engines;
mod figures;
mod files;
mod full;
mod fuzz;
mod landmarks;
mod models;
mod mutated;
mod watch;

use std::path::{Path, PathBuf};

use feeler_validation::{CheckRow, ValidationError};

fn scenarios() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios")
}

fn all_pass(rows: Result<Vec<CheckRow>, ValidationError>, at_least: usize) {
    let rows = rows.unwrap_or_else(|error| panic!("{error}"));
    assert!(rows.len() >= at_least);
    let failures: Vec<&CheckRow> = rows.iter().filter(|row| !row.pass).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}
