//! A short form of `cargo run --release -p feeler-validation --example fuzz -- 20000`.

use std::path::Path;

use feeler_validation::fuzz::{Fate, Fuzz};

/// Mutated files end with a run or with an error. A panic fails the test by itself.
#[test]
fn prop_mutated_files_are_refused_or_run() {
    let fuzz = Fuzz::of(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")));
    let fates: Vec<Fate> = (0..400).map(|number| fuzz.case(number).run()).collect();
    for fate in [Fate::Refused, Fate::Ran] {
        assert!(fates.iter().filter(|found| **found == fate).count() > 20, "{fate:?}");
    }
}
