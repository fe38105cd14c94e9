//! Rapier against the exact engine.

use feeler_validation::engines::{agreements, default_steps_s, engine_rows};

use crate::{all_pass, scenarios};

#[test]
fn order_two_engines_converge_to_each_other() {
    let found = agreements(Some(&scenarios()), &default_steps_s()).unwrap();
    assert_eq!(found.len(), 13);
    all_pass(Ok(engine_rows(&found)), found.len());
}
