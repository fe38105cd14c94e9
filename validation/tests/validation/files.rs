//! The scenario files of the paper's machines against the equations of motion written by hand.

use std::path::PathBuf;

use feeler_validation::Row;
use feeler_validation::files::file_rows;

#[test]
fn truth_scenario_files_have_the_paper_s_equations_of_motion() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../scenarios");
    let rows = file_rows(&folder).unwrap();
    assert_eq!(rows.len(), 20);
    let failures: Vec<&Row> = rows.iter().filter(|row| !row.pass).collect();
    assert!(failures.is_empty(), "{failures:#?}");
    assert!(file_rows(&folder.join("nowhere")).is_err());
}
