//! A short form of `cargo run --release -p feeler-validation --example fuzz -- 20000`.

use std::path::Path;

use crate::mutated::{Fate, Fuzz};

/// Mutated files end with a run or with an error. A panic fails the test by itself.
#[test]
fn prop_mutated_files_are_refused_or_run() {
    let fuzz = Fuzz::of(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")));
    let cases: Vec<(u64, Fate)> = (0..400)
        .map(|number| {
            let case = fuzz.case(number);
            (case.number, case.run())
        })
        .collect();
    for fate in [Fate::Refused, Fate::Ran] {
        let found: Vec<u64> =
            cases.iter().filter(|(_, of_case)| *of_case == fate).map(|(number, _)| *number).collect();
        assert!(found.len() > 20, "{fate:?}: {found:?}");
    }
}
