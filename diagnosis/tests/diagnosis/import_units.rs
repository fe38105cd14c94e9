//! Import of names and numbers without a unit or a meaning.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::import::{Options, Role, Survey, UnitGuess, import};

/// A target, and a position 50 ms later, times a factor.
fn log(folder: &Path, file: &str, names: [&str; 2], times: f64) {
    let wave = |t: f64| 0.5 * (2.0 * t).sin() + 0.2 * (5.3 * t).sin();
    let mut rows = format!("t_s,{},{}\n", names[0], names[1]);
    for k in 0..1200 {
        let t = 0.01 * f64::from(k);
        let _ = writeln!(rows, "{t},{:.7},{:.7}", wave(t), times * wave(t - 0.05));
    }
    fs::write(folder.join(file), rows).expect("written");
}

fn imported(file: &str, names: [&str; 2], times: f64, more: &Options) -> Survey {
    let folder = tempfile::tempdir().expect("a folder");
    log(folder.path(), file, names, times);
    import(&[&folder.path().join(file)], more, &|_| ()).expect("a survey")
}

#[test]
fn truth_a_position_in_another_unit_than_its_target_gets_the_unit_that_makes_them_one_motion() {
    for (times, expected) in [
        (1.0, None),
        (360.0 / TAU, Some(UnitGuess::Symbol("deg"))),
        (1e3, Some(UnitGuess::Counts(1e-3))),
        (-4096.0 / TAU, Some(UnitGuess::Counts(TAU / 4096.0))),
    ] {
        let survey = imported("a.csv", ["target", "position"], times, &Options::default());
        let guess = &survey.joints[""];
        let found = guess.columns[&Role::Position].unit.as_ref().map(|(unit, _)| *unit);
        assert_eq!(found, expected, "{times}");
        assert_eq!(guess.columns[&Role::Target].unit, None, "{times}");
        let follow = guess.follow.expect("it follows");
        assert_eq!(follow.is_turned(), times < 0.0, "{follow:?}");
        assert!((follow.lag_s - 0.05).abs() <= 0.0025, "{follow:?}");
    }
    // The target in degrees.
    let survey = imported("a.csv", ["target", "position"], TAU / 360.0, &Options::default());
    let found = &survey.joints[""].columns;
    assert_eq!(found[&Role::Target].unit.as_ref().map(|(unit, _)| *unit), Some(UnitGuess::Symbol("deg")));
    assert_eq!(found[&Role::Position].unit, None);
}

/// A file called after the target of a run still has a position.
#[test]
fn truth_the_name_of_a_file_does_not_replace_those_of_its_columns() {
    let survey = imported("target_steps.csv", ["target", "position"], 1.0, &Options::default());
    assert!(survey.joints[""].follow.is_some(), "{:?}", survey.joints);
}

/// Units of a slide make a slide of the first machine, so that the dataset is sound.
#[test]
fn truth_a_log_in_millimetres_gives_the_dataset_of_a_slide() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let options = Options { out: Some(out.clone()), ..Options::default() };
    imported("a.csv", ["target_mm", "slide_mm"], 1.0, &options);
    let dataset = Dataset::load(&out).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(dataset.machine.axis, feeler_plant::description::Axis::Translational);
    // The largest target of the file is 0.7 mm.
    let largest = dataset.records[0].commands[0].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert!((0.6e-3..0.7e-3).contains(&largest), "{largest} m");
}

#[test]
fn truth_a_stated_column_that_no_run_has_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    log(folder.path(), "a.csv", ["target", "position"], 1.0);
    let columns = vec![(Role::Target, "goal".to_owned()), (Role::Position, "position".to_owned())];
    let options = Options { columns, ..Options::default() };
    let error = import(&[&folder.path().join("a.csv")], &options, &|_| ()).expect_err("no such column");
    assert!(error.to_string().contains("there is no column `goal`"), "{error}");
}
