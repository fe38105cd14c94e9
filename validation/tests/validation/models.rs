//! The paper's models and the second axis against independent numbers.

use std::io::Write as _;
use std::path::PathBuf;

use feeler_validation::models::{critical_gain_rows, model_rows};

use crate::all_pass;

#[test]
fn reference_table_of_models() {
    all_pass(model_rows(), 50);
}

#[test]
fn reference_critical_gains_of_the_second_axis() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/reference/critical-gains.json");
    match std::fs::read_to_string(&path) {
        Ok(text) => all_pass(critical_gain_rows(&text), 80),
        Err(error) => drop(writeln!(std::io::stderr(), "skipped: {}: {error}", path.display())),
    }
}
