//! A short form of `cargo run --release -p feeler-validation --example fuzz -- 20000`.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::mutated::{Fate, Fuzz};
use crate::watch::{Failed, LONGEST_S, within};

/// Mutated files end with a run or with an error, and soon.
#[test]
fn prop_mutated_files_are_refused_or_run_soon() {
    let fuzz = Fuzz::of(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")));
    let cases: Vec<(u64, Fate)> = (0..400)
        .map(|number| {
            let case = fuzz.case(number);
            let of_case = case.clone();
            match within(LONGEST_S, move || of_case.run()) {
                Ok((fate, _)) => (number, fate),
                Err(failed) => panic!("{failed:?}: case {number} of {}\n{}", case.from.display(), case.text),
            }
        })
        .collect();
    for fate in [Fate::Refused, Fate::Ran] {
        let found: Vec<u64> =
            cases.iter().filter(|(_, of_case)| *of_case == fate).map(|(number, _)| *number).collect();
        assert!(found.len() > 20, "{fate:?}: {found:?}");
    }
}

/// A case that keeps a processor busy for too long is late, and one that ends is not. A panic is an outcome
/// of its own.
#[test]
fn truth_a_case_that_does_not_end_is_late() {
    const SHORT_S: f64 = 0.05;
    let stops = Arc::new(AtomicBool::new(false));
    let runs = Arc::clone(&stops);
    let endless = within(SHORT_S, move || while !runs.load(Ordering::Relaxed) {});
    stops.store(true, Ordering::Relaxed);
    assert_eq!(endless, Err(Failed::Late));
    assert_eq!(within(LONGEST_S, || 7).map(|(result, _)| result), Ok(7));
    assert_eq!(within(LONGEST_S, || panic!("meant to")), Err::<((), f64), _>(Failed::Panicked));
}
