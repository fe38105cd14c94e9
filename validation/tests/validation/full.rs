//! The whole table, which takes minutes:
//! `cargo test --release -p feeler-validation --test validation -- --ignored`.

use std::path::PathBuf;

use feeler_validation::{CheckRow, ValidateOptions, validate};

use crate::scenarios;

#[test]
#[ignore = "takes minutes; `feeler validate` makes the same checks"]
#[expect(clippy::print_stdout, reason = "a long run shows how far it is")]
fn reference_every_row_passes() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/reference/critical-gains.json");
    let options = ValidateOptions {
        critical_gains_json: std::fs::read_to_string(path).ok(),
        quick: false,
        scenarios: Some(scenarios()),
    };
    let table = validate(&options, |group| println!("{group}")).unwrap();
    let failures: Vec<&CheckRow> = table.failures().collect();
    assert!(failures.is_empty(), "{failures:#?}");
}
