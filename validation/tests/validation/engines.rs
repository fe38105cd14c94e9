//! Rapier against the exact engine.

use std::path::PathBuf;

use feeler_validation::engines::{agreements, default_steps_s, engine_rows};

#[test]
fn order_two_engines_converge_to_each_other() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../scenarios");
    let found = agreements(Some(&folder), &default_steps_s()).unwrap();
    assert_eq!(found.len(), 13);
    let failures: Vec<_> = engine_rows(&found).into_iter().filter(|row| !row.pass).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}
