//! The checks of the table in the forms that take seconds.

use std::path::Path;

use feeler_validation::experiments::{ResponseEffort, onset_row, paper_axes, response_rows, two_route_rows};
use feeler_validation::{claims, closed_forms, convergence, random_machines};

use crate::{all_pass, scenarios};

#[test]
fn truth_closed_forms() {
    all_pass(closed_forms::closed_form_rows(), 1);
}

#[test]
fn truth_transfer_functions_by_hand() {
    all_pass(two_route_rows(), 1);
}

#[test]
fn reference_claims_of_the_paper() {
    all_pass(claims::claim_rows(), 1);
}

/// With `FEELER_UPDATE_DOCS=1` the page is written instead.
#[test]
fn order_integrators_through_an_impact_and_the_page_that_shows_it() {
    let study = convergence::convergence(&scenarios(), &convergence::default_steps_s()).unwrap();
    let text = convergence::markdown(&study);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/convergence.md");
    if std::env::var_os("FEELER_UPDATE_DOCS").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap();
    assert!(committed == text, "docs/convergence.md is stale; run this test with FEELER_UPDATE_DOCS=1");
    all_pass(Ok(convergence::study_rows(&study)), 1);
}

#[test]
fn prop_random_machines() {
    all_pass(random_machines::random_machine_rows(500), 1);
}

#[test]
fn truth_measured_response_of_the_rigid_axis() {
    let (name, axis) = &paper_axes()[1];
    all_pass(response_rows(name, axis, ResponseEffort::QUICK), 1);
}

#[test]
fn truth_onset_of_instability_of_the_rigid_axis() {
    let (name, axis) = &paper_axes()[0];
    all_pass([0.0, 0.37, 1.0, 2.5].iter().map(|&delay| onset_row(name, axis, delay, 10.0)).collect(), 1);
}
