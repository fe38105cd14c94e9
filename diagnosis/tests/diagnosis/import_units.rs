//! Import of names and numbers without a unit or a meaning.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::import::{ColumnRole, Options, Survey, UnitGuess, import};

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
        (360.0 / TAU, Some(UnitGuess::Symbol("deg".into()))),
        (1e3, Some(UnitGuess::Counts(1e-3))),
        (-4096.0 / TAU, Some(UnitGuess::Counts(TAU / 4096.0))),
    ] {
        let survey = imported("a.csv", ["target", "position"], times, &Options::default());
        let guess = &survey.joints[""];
        let found = guess.columns[&ColumnRole::Position].unit.as_ref().map(|(unit, _)| unit.clone());
        assert_eq!(found, expected, "{times}");
        assert_eq!(guess.columns[&ColumnRole::Target].unit, None, "{times}");
        let follow = guess.follow.expect("it follows");
        assert_eq!(follow.is_turned(), times < 0.0, "{follow:?}");
        assert!((follow.lag_s - 0.05).abs() <= 0.0025, "{follow:?}");
    }
    // The target in degrees.
    let survey = imported("a.csv", ["target", "position"], TAU / 360.0, &Options::default());
    let found = &survey.joints[""].columns;
    assert_eq!(
        found[&ColumnRole::Target].unit.as_ref().map(|(unit, _)| unit.clone()),
        Some(UnitGuess::Symbol("deg".into()))
    );
    assert_eq!(found[&ColumnRole::Position].unit, None);
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
    let columns =
        vec![(ColumnRole::Target, "goal".to_owned()), (ColumnRole::Position, "position".to_owned())];
    let options = Options { columns, ..Options::default() };
    let error = import(&[&folder.path().join("a.csv")], &options, &|_| ()).expect_err("no such column");
    assert!(error.to_string().contains("there is no column `goal`"), "{error}");
}

/// A controller lists its joints in an order of its own, without names. Two joints that move alike stay
/// apart from their targets: nothing tells which is whose.
#[test]
fn truth_targets_without_names_belong_to_the_positions_that_follow_each_alone() {
    let waves: [fn(f64) -> f64; 2] = [|t| (2.0 * t).sin(), |t| (1.3 * t).cos() + 0.4 * (4.1 * t).sin()];
    for (of_wrist, paired) in [(1, true), (0, false)] {
        let folder = tempfile::tempdir().expect("a folder");
        let mut commands = "t_s,data[0],data[1]\n".to_owned();
        let mut states = "t_s,position[wrist],position[elbow]\n".to_owned();
        for k in 0..1200 {
            let t = 0.01 * f64::from(k);
            let of = |joint: usize, t: f64| waves[joint](t);
            let _ = writeln!(commands, "{t},{:.6},{:.6}", of(0, t), of(of_wrist, t));
            let late = t - 0.06;
            let _ = writeln!(states, "{t},{:.6},{:.6}", of(of_wrist, late), of(0, late));
        }
        fs::write(folder.path().join("commands.csv"), commands).expect("written");
        fs::write(folder.path().join("joint_states.csv"), states).expect("written");
        let survey = import(&[folder.path()], &Options::default(), &|_| ()).expect("a survey");
        let target = |joint: &str| {
            survey.joints[joint].columns.get(&ColumnRole::Target).map(|chosen| chosen.column.as_str())
        };
        let expected = if paired { [Some("commands.data[0]"), Some("commands.data[1]")] } else { [None; 2] };
        assert_eq!(["elbow", "wrist"].map(target), expected, "{:?}", survey.joints);
    }
}

#[test]
fn truth_a_plan_of_several_points_is_no_target() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("plan.csv");
    let mut rows = "t_s,points[0].positions[elbow],points[1].positions[elbow],position[elbow]\n".to_owned();
    for k in 0..100 {
        let t = 0.1 * f64::from(k);
        let _ = writeln!(rows, "{t},{:.6},{:.6},{:.6}", t.sin(), (t + 0.05).sin(), (t - 0.1).sin());
    }
    fs::write(&file, rows).expect("written");
    let survey = import(&[&file], &Options::default(), &|_| ()).expect("a survey");
    assert_eq!(survey.joints["elbow"].columns.get(&ColumnRole::Target), None);
    assert!(survey.notes[0].contains("plans of several points"), "{:?}", survey.notes);
}

/// A recorder that asks more often than values change writes rows twice. Two different rows of one instant
/// stay an error.
#[test]
fn truth_rows_that_repeat_are_left_out_and_counted() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, twice: &dyn Fn(u32, &str) -> String| {
        let mut rows = "t_s,target,position\n".to_owned();
        for k in 0..200 {
            let t = 0.01 * f64::from(k);
            rows.push_str(&twice(k, &format!("{t},{:.6},{:.6}\n", (9.0 * t).sin(), (9.0 * t - 0.2).sin())));
        }
        let file = folder.path().join(name);
        fs::write(&file, rows).expect("written");
        let options = Options { out: Some(folder.path().join(format!("{name}-out"))), ..Options::default() };
        import(&[&file], &options, &|_| ())
    };
    let survey =
        write("a.csv", &|k, row| if k % 3 == 1 { row.repeat(2) } else { row.into() }).expect("a survey");
    let said = survey.notes.iter().any(|note| note.contains("time and all, are left out: 67"));
    assert!(said, "{:?}", survey.notes);
    let dataset = Dataset::load(&survey.datasets[0].folder).expect("it loads");
    assert_eq!(dataset.records[0].times_s.len(), 200);
    let error = write("b.csv", &|k, row| if k == 90 { format!("{row}0.9,5,5\n") } else { row.into() });
    let error = error.expect_err("two rows of one instant").to_string();
    assert!(error.contains("row 93") && error.contains("does not advance beyond 0.9 s"), "{error}");
}
