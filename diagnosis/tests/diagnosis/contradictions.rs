//! Wrong units, signs and clocks in a column of the example dataset, in some experiments or in all. The
//! tests check which column is named, and with which factor.

use std::fs;
use std::path::Path;

use feeler_diagnosis::adequacy::Condition;
use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::diagnose;
use feeler_diagnosis::report::Verdict;
use feeler_plant::effects::Kind;
use tempfile::TempDir;

const FILES: [&str; 6] =
    ["free-sines-1.csv", "free-sines-2.csv", "press-1.csv", "press-3.csv", "strokes-1.csv", "strokes-2.csv"];
const PRESSES: [&str; 2] = ["press-1.csv", "press-3.csv"];
const SINES: [&str; 2] = ["free-sines-1.csv", "free-sines-2.csv"];

/// The faulty reading of a row, from the column's readings.
type Spoiling = fn(&[f64], usize) -> f64;

/// A fault: file, column, and what happens to its readings.
type Fault<'a> = (&'a str, &'a str, Spoiling);

/// The files `kept` of the example, with faults.
fn example(kept: &[&str], faults: &[Fault<'_>]) -> Dataset {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/datasets/bench-axis");
    let folder = TempDir::new().expect("the example is sound");
    fs::copy(source.join("machine.toml"), folder.path().join("machine.toml")).expect("the example is sound");
    let text = fs::read_to_string(source.join("dataset.toml")).expect("the example is sound");
    let parts: Vec<&str> = text.split("[[experiments]]").collect();
    let named = parts[1..].iter().filter(|part| kept.iter().any(|file| part.contains(file)));
    let text: String = std::iter::once(parts[0].to_owned())
        .chain(named.map(|part| format!("[[experiments]]{part}")))
        .collect();
    fs::write(folder.path().join("dataset.toml"), text).expect("the example is sound");
    for file in kept {
        let mut text = fs::read_to_string(source.join(file)).expect("the example is sound");
        for (_, column, fault) in faults.iter().filter(|(of, ..)| of == file) {
            text = spoilt(&text, column, *fault);
        }
        fs::write(folder.path().join(file), text).expect("the example is sound");
    }
    Dataset::load(folder.path()).expect("the example is sound")
}

/// Warnings about the example with these faults.
fn said(kept: &[&str], faults: &[Fault<'_>]) -> Vec<String> {
    example(kept, faults).warnings.iter().map(ToString::to_string).collect()
}

fn spoilt(text: &str, column: &str, fault: Spoiling) -> String {
    let mut rows: Vec<Vec<String>> =
        text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
    let at = rows[0].iter().position(|name| name == column).expect("the example is sound");
    let values: Vec<f64> =
        rows[1..].iter().map(|row| row[at].parse().expect("the example is sound")).collect();
    for (k, row) in rows[1..].iter_mut().enumerate() {
        row[at] = fault(&values, k).to_string();
    }
    rows.iter().map(|row| row.join(",") + "\n").collect()
}

fn late(values: &[f64], row: usize) -> f64 {
    values[row.saturating_sub(12)]
}

/// Asserts that one of the sentences has all words.
fn has(said: &[String], words: &[&str]) {
    assert!(said.iter().any(|line| words.iter().all(|word| line.contains(word))), "{words:?} in {said:#?}");
}

#[test]
fn truth_the_example_contradicts_itself_nowhere() {
    let said = said(&FILES, &[]);
    assert!(said.iter().all(|line| line.contains("excite more strongly")), "{said:#?}");
}

#[test]
fn truth_accelerometers_on_one_rigid_body_tell_of_each_others_units_and_clocks() {
    let faults: [Fault<'_>; 2] = [
        ("press-1.csv", "tip_acceleration_mps2", |v, k| v[k] / 9.81),
        ("press-3.csv", "tip_acceleration_mps2", late),
    ];
    let said = said(&PRESSES, &faults);
    has(&said, &["press-1.csv: `tip_acceleration_mps2`: reads ", "1/9.81 (g for m/s²?)"]);
    has(&said, &["press-3.csv: `tip_acceleration_mps2`: runs ", "behind"]);
    assert!(
        !said.iter().any(|line| line.contains("tip_acceleration") && line.contains("excite")),
        "{said:#?}"
    );
}

#[test]
fn truth_the_column_that_stands_alone_is_the_suspect() {
    let faults: [Fault<'_>; 2] = [
        ("free-sines-2.csv", "encoder_m", |v, k| 1e3 * v[k]),
        ("strokes-1.csv", "tip_acceleration_mps2", |v, k| 1e3 * v[k]),
    ];
    let said = said(&["free-sines-2.csv", "strokes-1.csv"], &faults);
    has(&said, &["free-sines-2.csv: `encoder_m`: reads ", "1000 (mm for m?)"]);
    has(&said, &["strokes-1.csv: `tip_acceleration_mps2`: reads ", "1000 (mm/s² for m/s²?)"]);
    assert!(!said.iter().any(|line| line.contains("`motor_acceleration_mps2`: reads")), "{said:#?}");
}

#[test]
fn truth_a_force_is_held_against_what_pushes_it() {
    let faults: [Fault<'_>; 2] =
        [("press-1.csv", "force_n", late), ("press-3.csv", "force_n", |v, k| 1e-3 * v[k])];
    let said = said(&PRESSES, &faults);
    has(&said, &["press-3.csv: `force_n`: reads ", "1/1000 (kN for N?)"]);
    has(&said, &["press-1.csv: `force_n`: runs ", "later here than in press-3.csv"]);
}

#[test]
fn truth_a_clock_that_is_late_everywhere_is_counted() {
    let faults: [Fault<'_>; 2] =
        [("press-1.csv", "motor_acceleration_mps2", late), ("press-3.csv", "motor_acceleration_mps2", late)];
    let said = said(&PRESSES, &faults);
    has(&said, &["press-1.csv: `motor_acceleration_mps2`: runs ", "behind", "as in another experiment"]);
    assert!(
        !said
            .iter()
            .any(|line| line.contains("`tip_acceleration_mps2`: runs") || line.contains("`encoder_m`: runs")),
        "{said:#?}"
    );
}

#[test]
fn truth_commands_in_kilonewtons_and_a_turned_encoder_are_named() {
    let faults: [Fault<'_>; 2] = [
        ("free-sines-1.csv", "command_n", |v, k| 1e-3 * v[k]),
        ("free-sines-2.csv", "encoder_m", |v, k| -v[k]),
    ];
    let said = said(&["free-sines-1.csv", "free-sines-2.csv"], &faults);
    has(&said, &["free-sines-1.csv: `command_n`: reads ", "1/1000 (kN for N?)"]);
    has(&said, &["free-sines-2.csv: `encoder_m`: reads ", "a sign"]);
}

/// A delay of 86 rows, 43 ms.
fn very_late(values: &[f64], row: usize) -> f64 {
    values[row.saturating_sub(86)]
}

#[test]
fn regress_a_clock_that_is_far_off_among_other_faults_accuses_nobody_else() {
    let faults: [Fault<'_>; 4] = [
        ("press-1.csv", "tip_acceleration_mps2", very_late),
        ("press-3.csv", "force_n", |v, k| 1e-3 * v[k]),
        ("strokes-1.csv", "encoder_m", |v, k| (v[k] / 2e-5).round() * 2e-5),
        ("free-sines-1.csv", "motor_acceleration_mps2", |v, k| v[k].clamp(-3.0, 3.0)),
    ];
    let said = said(&FILES, &faults);
    has(&said, &["press-1.csv: `tip_acceleration_mps2`: runs 4", "behind `encoder_m`"]);
    has(&said, &["press-3.csv: `force_n`: reads ", "1/1000 (kN for N?)"]);
    has(&said, &["strokes-1.csv: `encoder_m`", "multiples of"]);
    has(&said, &["free-sines-1.csv:", "`motor_acceleration_mps2`", "rows sit at 3 "]);
    assert_eq!(said.iter().filter(|line| line.contains(": runs ")).count(), 1, "{said:#?}");
}

#[test]
fn regress_a_force_is_not_accused_of_an_encoder_that_is_late() {
    let said = said(&PRESSES, &[("press-1.csv", "encoder_m", very_late)]);
    has(&said, &["press-1.csv: `encoder_m`: runs 4", "behind `tip_acceleration_mps2`"]);
    assert!(!said.iter().any(|line| line.contains("`force_n`")), "{said:#?}");
}

#[test]
fn truth_a_command_that_is_late_in_one_experiment_is_named() {
    let said = said(&FILES, &[("free-sines-1.csv", "command_n", very_late)]);
    has(&said, &["free-sines-1.csv: `command_n`: runs 4", "later here than in free-sines-2.csv"]);
    assert_eq!(said.iter().filter(|line| line.contains(": runs ")).count(), 1, "{said:#?}");
}

#[test]
fn regress_a_command_that_is_late_in_contact_accuses_nobody() {
    let said = said(&PRESSES, &[("press-1.csv", "command_n", very_late)]);
    // An impact is larger than the steps of the command, so no delay of the command is reported.
    assert!(!said.iter().any(|line| line.contains(": runs ")), "{said:#?}");
}

/// A slow stroke against damping: the phase lead of the command is not a fault of a clock.
#[test]
fn regress_a_slow_motion_against_damping_is_no_late_clock() {
    let slow: Fault<'_> = ("free-sines-1.csv", "command_n", |v, k| {
        v[k] + 150.0 * (std::f64::consts::TAU * 5e-4 * k as f64).cos()
    });
    let said = said(&["free-sines-1.csv", "free-sines-2.csv"], &[slow]);
    assert!(!said.iter().any(|line| line.contains("`command_n`: runs")), "{said:#?}");
}

/// Columns that are frozen or clipped are not scored, and must not correct the prediction either.
#[test]
fn regress_columns_that_do_not_count_move_nothing() {
    let faults: [Fault<'_>; 2] = [
        ("free-sines-1.csv", "tip_acceleration_mps2", |_, _| 0.0),
        ("press-1.csv", "force_n", |v, k| v[k].min(15.0)),
    ];
    let files = ["free-sines-1.csv", "free-sines-2.csv", "press-1.csv"];
    let found = diagnose(&example(&files, &faults), &|_| ()).expect("it is diagnosed");
    let accepted = |kind: Kind, parameter: &str| {
        let cause = found.effects.iter().find(|effect| effect.accepted && effect.kind == kind);
        cause.unwrap_or_else(|| panic!("no {kind}")).parameters[parameter].clone()
    };
    assert_eq!(found.effects.iter().filter(|effect| effect.accepted).count(), 2);
    // The hidden values of the example (its README) lie within the stated intervals.
    for (estimate, hidden) in
        [(accepted(Kind::CoulombFriction, "level"), 7.53), (accepted(Kind::CommandDelay, "delay"), 1.92e-3)]
    {
        assert!((estimate.ci90[0]..estimate.ci90[1]).contains(&hidden), "{estimate:?}");
    }
}

/// The answer names the column, is not sure, and says that the records contradict each other.
#[test]
fn truth_a_wrong_sign_or_unit_of_a_column_leaves_no_sure_answer() {
    let faults: [([&str; 2], &str, Spoiling); 3] = [
        (PRESSES, "force_n", |v, k| -v[k]),
        (SINES, "encoder_m", |v, k| 1e3 * v[k]),
        (SINES, "command_n", |v, k| -v[k]),
    ];
    for (files, column, fault) in faults {
        let found = diagnose(&example(&files, &files.map(|file| (file, column, fault))), &|_| ()).unwrap();
        let named = found.contradictions.iter().filter(|said| said.contains(&format!("`{column}`")));
        assert!(named.count() > 0, "{column}: {:?}", found.contradictions);
        assert_ne!(found.verdict, Verdict::Explained, "{column}");
        let is_of_records =
            found.adequacy.shortfalls.iter().any(|short| short.condition == Condition::Records);
        assert!(is_of_records, "{column}: {:?}", found.adequacy.shortfalls);
    }
}
