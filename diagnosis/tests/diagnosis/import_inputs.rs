//! Import of logs whose inputs are no targets, whose columns have no names, and whose rows have breaks.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use feeler_diagnosis::dataset::{Dataset, Record};
use feeler_diagnosis::import::{ColumnRole, Model, Options, Survey, import};
use feeler_files::Document;
use feeler_plant::description::{ActuatorKind, MotorInput};

const MOTOR: &str = "axis = \"rotational\"\n[bodies.link]\nmass = 0.02\n[actuators.motor]\non = \"link\"\n\
    kind = \"dc-motor\"\nresistance = 4.0\ntorque_constant = 0.01\ngear_ratio = 100.0\n\
    [sensors.encoder]\nreads = \"link.position\"\nnoise = 1e-5\n";

fn voltage(t: f64) -> f64 {
    4.0 * (3.0 * t).sin() + 2.0 * (11.0 * t).sin()
}

fn position(t: f64) -> f64 {
    0.5 * (3.0 * t - 0.4).sin()
}

/// Rows of a clock and two columns at 100 Hz; without a header if there are no names.
fn rows(names: Option<[&str; 2]>, is_kept: impl Fn(f64) -> bool, columns: [fn(f64) -> f64; 2]) -> String {
    let mut text = names.map_or_else(String::new, |[a, b]| format!("t_s,{a},{b}\n"));
    for k in 0..4000 {
        let t = 0.01 * f64::from(k);
        if is_kept(t) {
            let _ = writeln!(text, "{t:.2},{:.6},{:.6}", columns[0](t), columns[1](t));
        }
    }
    text
}

fn imported(folder: &Path, text: &str, more: Options) -> Survey {
    let log = folder.join("log.csv");
    fs::write(&log, text).expect("written");
    let out = Some(folder.join("out"));
    import(&[&log], &Options { out, ..more }, &|_| ()).expect("a survey")
}

/// A name tells it, or the user does. The position beside it need not be stated if there is only one.
#[test]
fn truth_a_logged_voltage_or_duty_cycle_is_the_command_of_a_motor() {
    let stated = |column: &str| vec![(ColumnRole::Command, column.to_owned())];
    for (names, columns) in [
        (["knee_voltage_cmd", "knee_pos"], Vec::new()),
        (["pwm[knee]", "position[knee]"], Vec::new()),
        (["u_V", "q_rad"], stated("u_V")),
        (["motor_voltage", "position"], stated("motor_voltage")),
    ] {
        for is_given in [false, true] {
            let folder = tempfile::tempdir().expect("a folder");
            let machine = folder.path().join("motor.toml");
            fs::write(&machine, MOTOR).expect("written");
            let model = is_given.then_some(Model::Machine(machine));
            let text = rows(Some(names), |_| true, [voltage, position]);
            let survey = imported(
                folder.path(),
                &text,
                Options { columns: columns.clone(), model, ..Options::default() },
            );
            let written = survey.datasets.first().unwrap_or_else(|| panic!("{names:?}: {:?}", survey.notes));
            let dataset = Dataset::load(&written.folder).expect("it is sound");
            let kind = &dataset.machine.actuators[dataset.drives[0].drive].kind;
            if is_given {
                let ActuatorKind::DcMotor(motor) = kind else { panic!("{kind:?}") };
                assert_eq!(motor.input, MotorInput::Voltage);
            } else {
                assert!(matches!(kind, ActuatorKind::Force { .. }), "{kind:?}");
                let said = written.assumptions.join(" ");
                assert!(said.contains("the command is a voltage or a share of it"), "{said}");
            }
            let command = &dataset.records[0].commands[0];
            assert!((command[123] - voltage(1.23)).abs() < 1e-6, "{}", command[123]);
        }
    }
    // The voltage of a supply is not a command.
    let folder = tempfile::tempdir().expect("a folder");
    let text = rows(Some(["present_voltage", "position"]), |_| true, [voltage, position]);
    let survey = imported(folder.path(), &text, Options::default());
    assert!(survey.datasets.is_empty());
    let said = survey.notes.join(" ");
    assert!(said.contains("`position` is the position") && said.contains("--command COLUMN"), "{said}");
}

/// Numbers alone. The note says which two columns belong together, and its options make the dataset.
#[test]
fn truth_columns_without_names_are_stated_by_their_numbers() {
    let text = rows(None, |_| true, [position, |t| position(t - 0.06)]);
    let folder = tempfile::tempdir().expect("a folder");
    let survey = imported(folder.path(), &text, Options::default());
    assert!(survey.datasets.is_empty());
    let said = survey.notes.join(" ");
    assert!(said.contains("`3` follows `2` 60 ms later"), "{said}");
    assert!(said.contains("`--target 2 --position 3`"), "{said}");
    let columns = vec![(ColumnRole::Target, "2".to_owned()), (ColumnRole::Position, "3".to_owned())];
    let survey = imported(folder.path(), &text, Options { columns, ..Options::default() });
    let dataset = Dataset::load(&survey.datasets[0].folder).expect("it is sound");
    assert_eq!(dataset.records[0].len(), 4000);
    let target = dataset.records[0].commands[0][123];
    assert!((target - position(1.23)).abs() < 1e-6, "{target}");
}

/// Rows are missing from 15 to 27 s. Both parts are on one clock, so the second follows the first.
#[test]
fn truth_a_log_with_a_break_is_two_experiments_on_one_clock() {
    let folder = tempfile::tempdir().expect("a folder");
    let is_kept = |t: f64| !(15.0..27.0).contains(&t);
    let text = rows(Some(["target", "position"]), is_kept, [position, |t| position(t - 0.06)]);
    let survey = imported(folder.path(), &text, Options::default());
    let said = survey.notes.join(" ");
    assert!(said.contains("12.01 s are missing before row 1502"), "{said}");
    assert_eq!(survey.datasets[0].experiments, ["log-1.csv", "log-2.csv"]);
    let dataset = Dataset::load(&survey.datasets[0].folder).expect("both parts are sound");
    assert_eq!(dataset.records.iter().map(Record::len).collect::<Vec<_>>(), [1500, 1300]);
    let before = dataset.records[1].before.as_ref().expect("the first part");
    assert_eq!(before.name, "log-1.csv");
    assert!((dataset.records[1].start_s - 27.0).abs() < 1e-9);
    assert!(Document::load(&survey.datasets[0].folder.join("machine.toml")).is_ok());
}
