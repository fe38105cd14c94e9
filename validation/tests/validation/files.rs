//! The scenario files of the paper's machines against the equations of motion written by hand.

use feeler_validation::files::file_rows;

use crate::{all_pass, scenarios};

#[test]
fn truth_scenario_files_have_the_paper_s_equations_of_motion() {
    let rows = file_rows(&scenarios()).unwrap();
    assert_eq!(rows.len(), 20);
    all_pass(Ok(rows), 20);
    assert!(file_rows(&scenarios().join("nowhere")).is_err());
}
