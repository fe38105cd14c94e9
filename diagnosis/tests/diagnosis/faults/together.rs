//! Faults of a dataset as a whole: what its experiments have together.

use std::fs;

use feeler_diagnosis::dataset::{Dataset, in_words};
use feeler_diagnosis::{DiagnosisError, diagnose};
use feeler_problem::Remedy;
use tempfile::TempDir;

use super::{csv, folder, sound, spoil};

#[test]
fn regress_a_diagnosis_wants_something_to_fit_and_something_to_check() {
    let one = folder(&[("a.csv", csv(&sound()).as_bytes())]);
    let error = diagnose(&Dataset::load(one.path()).expect("it is sound"), &|_| ())
        .expect_err("there is nothing to check");
    assert!(matches!(error, DiagnosisError::Roles { fitted: 1, checked: 0 }), "{error}");
    assert!(error.remedy().contains("record one more"), "{error}");
    let text = csv(&sound());
    let both = folder(&[("a.csv", text.as_bytes()), ("b.csv", text.as_bytes())]);
    let file = both.path().join("dataset.toml");
    let checks =
        fs::read_to_string(&file).expect("it is there").replace(".csv\"\n", ".csv\"\nrole = \"check\"\n");
    fs::write(&file, checks).expect("it is written");
    let error = diagnose(&Dataset::load(both.path()).expect("it is sound"), &|_| ())
        .expect_err("there is nothing to fit");
    assert!(matches!(error, DiagnosisError::Roles { fitted: 0, checked: 2 }), "{error}");
}

/// A copied check repeats the fitted noise. A single different reading makes it another measurement.
#[test]
fn regress_a_check_that_copies_a_fitted_record_is_an_error() {
    let said_with = |check: &str| {
        let folder = folder(&[("a.csv", csv(&sound()).as_bytes()), ("b.csv", check.as_bytes())]);
        let file = folder.path().join("dataset.toml");
        let roles = fs::read_to_string(&file)
            .expect("it is there")
            .replace("\"b.csv\"\n", "\"b.csv\"\nrole = \"check\"\n");
        fs::write(&file, roles).expect("it is written");
        Dataset::load(folder.path()).map(|_| ()).map_err(|error| error.to_string())
    };
    let said = said_with(&csv(&sound())).expect_err("a copy");
    assert!(said.contains("b.csv: has the same rows as a.csv, which is fitted"), "{said}");
    let other = spoil(|k, row| row[2] += if k == 700 { 1e-8 } else { 0.0 });
    assert_eq!(said_with(&other), Ok(()));
}

/// States the hold of the command in a dataset.
fn state_hold(folder: &TempDir, hold: &str) {
    let file = folder.path().join("dataset.toml");
    let held = fs::read_to_string(&file)
        .expect("it is there")
        .replace("\"drive.command\"\n", &format!("\"drive.command\"\nhold = \"{hold}\"\n"));
    fs::write(&file, held).expect("it is written");
}

#[test]
fn regress_time_in_milliseconds_is_an_error() {
    let folder =
        folder(&[("a.csv", spoil(|_, row| row[0] *= 1e3).as_bytes()), ("b.csv", csv(&sound()).as_bytes())]);
    state_hold(&folder, "1 ms");
    let said = Dataset::load(folder.path()).expect_err("an error").to_string();
    assert!(
        said.contains("a.csv: rows are 1.0000 s apart") && said.contains("bring the time to seconds"),
        "{said}"
    );
}

#[test]
fn truth_a_hold_longer_than_the_time_between_commands_is_a_warning() {
    let warned = |hold: &str| {
        let other = spoil(|k, row| row[2] += if k == 700 { 1e-8 } else { 0.0 });
        let folder = folder(&[("a.csv", csv(&sound()).as_bytes()), ("b.csv", other.as_bytes())]);
        state_hold(&folder, hold);
        let dataset = Dataset::load(folder.path()).expect("it is sound otherwise");
        in_words(&dataset.warnings).join("\n")
    };
    let said = warned("50 ms");
    assert!(said.contains("`command_n`: changes every 1.001 ms on average"), "{said}");
    assert!(said.contains("though it is held for 50.000 ms"), "{said}");
    assert!(!warned("1 ms").contains("held for"));
}

/// An accelerometer that is frozen in one of the experiments counts neither for nor against a machine there.
#[test]
fn regress_a_channel_that_never_changes_does_not_score() {
    let (sound, hung) = (csv(&sound()), spoil(|_, row| row[3] = 9.0));
    let folder =
        folder(&[("a.csv", sound.as_bytes()), ("b.csv", hung.as_bytes()), ("c.csv", sound.as_bytes())]);
    let found =
        diagnose(&Dataset::load(folder.path()).expect("it is loaded"), &|_| ()).expect("it is diagnosed");
    // The accelerometer is frozen in half of the scored experiments. If it were scored, the error would
    // exceed its variation.
    assert!(found.gap.refit < 0.5, "{:?}", found.gap);
}

#[test]
fn regress_causes_are_tried_beside_a_channel_that_never_changes() {
    let (sound, hung) = (csv(&sound()), spoil(|_, row| row[3] = 0.0));
    let folder =
        folder(&[("a.csv", hung.as_bytes()), ("b.csv", sound.as_bytes()), ("c.csv", sound.as_bytes())]);
    let found =
        diagnose(&Dataset::load(folder.path()).expect("it is loaded"), &|_| ()).expect("it is diagnosed");
    // The records were made with a load of 1 N, without the believed friction.
    assert!(
        found.attempts.iter().any(|attempt| attempt.gain_all.is_some_and(|gain| gain > 0.0)),
        "{:?}",
        found.attempts
    );
}
