//! Import of real logs as datasets.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use feeler_diagnosis::DiagnosisError;
use feeler_diagnosis::dataset::{Dataset, Record};
use feeler_diagnosis::import::{ColumnRole, Model, Options, import};
use feeler_plant::description::ActuatorKind;
use feeler_problem::Remedy;

const MACHINE: &str = "axis = \"rotational\"\n[bodies.link]\nmass = 0.1\n[actuators.drive]\non = \"link\"\n\
    [sensors.encoder]\nreads = \"link.position\"\nnoise = 1e-5\n";

/// A log of two joints in which targets and positions are in separate files, 60 ms apart.
fn two_joints(folder: &Path) {
    let wave = |t: f64, j: f64| 0.5 * ((2.0 + j) * t).sin() + 0.2 * ((7.0 + j) * t + j).sin();
    let (mut control, mut state) =
        ("timestamp,positions\n".to_owned(), "timestamp,positions,torques\n".to_owned());
    for k in 0..1500 {
        let t = f64::from(k) * 0.02;
        let at = |shift: f64| [wave(t - shift, 0.0), wave(t - shift, 1.0)].map(|x| x.to_string()).join(", ");
        let _ = writeln!(control, "{},\"[{}]\"", t * 1e6, at(0.0));
        let _ = writeln!(state, "{},\"[{}]\",\"[0.1, 0.{}]\"", t * 1e6, at(0.06), k % 7);
    }
    fs::write(folder.join("control.csv"), control).expect("written");
    fs::write(folder.join("state.csv"), state).expect("written");
    fs::write(folder.join("joint_list.txt"), "hip\nknee\n").expect("written");
}

#[test]
fn truth_targets_and_positions_are_paired_and_their_lag_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    two_joints(folder.path());
    let survey = import(&[folder.path()], &Options::default(), &|_| ()).expect("a survey");
    assert_eq!(survey.runs.len(), 1);
    let clock = survey.runs[0].tables[0].clock.as_ref().expect("a clock");
    assert_eq!((clock.0.as_str(), clock.1), ("timestamp", "us"));
    for joint in ["hip", "knee"] {
        let guess = &survey.joints[joint];
        assert_eq!(guess.columns[&ColumnRole::Target].column, format!("control.positions[{joint}]"));
        assert_eq!(guess.columns[&ColumnRole::Position].column, format!("state.positions[{joint}]"));
        let follow = guess.follow.expect("it follows");
        // Lags are tried in steps of 2.5 ms.
        assert!((follow.lag_s - 0.06).abs() <= 0.0025 && follow.correlation > 0.999, "{follow:?}");
    }
}

#[test]
fn truth_a_dataset_of_a_given_machine_holds_the_numbers_of_the_log() {
    let folder = tempfile::tempdir().expect("a folder");
    two_joints(folder.path());
    let machine = folder.path().join("machine.toml");
    fs::write(&machine, MACHINE).expect("written");
    let out = folder.path().join("knee");
    let options = Options {
        out: Some(out.clone()),
        joint: Some("knee".into()),
        model: Some(Model::Machine(machine)),
        ..Options::default()
    };
    let survey = import(&[folder.path()], &options, &|_| ()).expect("a dataset");
    assert_eq!(survey.datasets[0].experiments.len(), 1);
    let dataset = Dataset::load(&out).expect("it is sound");
    let record = &dataset.records[0];
    assert_eq!(record.len(), 1500);
    let wave = |t: f64| 0.5 * (3.0 * t).sin() + 0.2 * (8.0 * t + 1.0).sin();
    for k in 0..1500 {
        let t = f64::from(k as u32) * 0.02;
        assert_eq!(record.commands[0][k].to_bits(), wave(t).to_bits(), "row {k}");
        assert_eq!(record.series[0][k].to_bits(), wave(t - 0.06).to_bits(), "row {k}");
    }
    let again = import(&[folder.path()], &options, &|_| ()).expect_err("there is one already");
    assert!(again.to_string().contains("there is a dataset already"), "{again}");
    let other = Options { joint: Some("ankle".into()), out: Some(folder.path().join("x")), ..options };
    let error = import(&[folder.path()], &other, &|_| ()).expect_err("no such joint");
    assert!(
        matches!(error, DiagnosisError::NoJoint { .. }) && error.remedy().contains("hip, knee"),
        "{error}"
    );
}

/// Speeds and forces logged with the targets become inputs of the servo if they vary in any run. Here the
/// velocities of the knee and the forces of the second run are all zero.
#[test]
fn truth_speeds_and_forces_beside_targets_are_inputs_of_the_servo() {
    let folder = tempfile::tempdir().expect("a folder");
    let lead = |t: f64, size: f64| size * (5.0 * t).sin();
    let sizes = [0.1, 0.0];
    let runs = ["first", "second"].map(|name| folder.path().join(name));
    for (run, size) in runs.iter().zip(sizes) {
        fs::create_dir(run).expect("a folder");
        two_joints(run);
        let mut control = "timestamp,positions,velocities,efforts\n".to_owned();
        for k in 0..1500 {
            let t = f64::from(k) * 0.02;
            let (hip, knee, speed) = ((2.0 * t).sin(), (3.0 * t).sin(), 2.0 * (2.0 * t).cos());
            let force = lead(t, size);
            let _ = writeln!(
                control,
                "{},\"[{hip}, {knee}]\",\"[{speed}, 0.0]\",\"[{force}, {}]\"",
                t * 1e6,
                -force
            );
        }
        fs::write(run.join("control.csv"), control).expect("written");
    }
    let out = folder.path().join("out");
    let options = Options { out: Some(out.clone()), ..Options::default() };
    let paths: Vec<&Path> = runs.iter().map(PathBuf::as_path).collect();
    import(&paths, &options, &|_| ()).expect("two datasets");
    for (joint, sign, expected) in [
        ("hip", 1.0, &["target", "target-velocity", "feed-forward"][..]),
        ("knee", -1.0, &["target", "feed-forward"][..]),
    ] {
        let dataset = Dataset::load(&out.join(joint)).expect("it is sound");
        let inputs: Vec<&str> = dataset.drives.iter().map(|driven| driven.column.as_str()).collect();
        assert_eq!(inputs, expected);
        let last = dataset.drives.len() - 1;
        let kind = &dataset.machine.actuators[dataset.drives[last].drive].kind;
        assert!(matches!(kind, ActuatorKind::FeedForward), "{kind:?}");
        assert_eq!(dataset.records.len(), 2);
        for (record, size) in dataset.records.iter().zip(sizes) {
            for (k, given) in record.commands[last].iter().enumerate() {
                // A converter that writes -0 means 0.
                let wanted = sign * lead(f64::from(k as u32) * 0.02, size) + 0.0;
                assert_eq!(given.to_bits(), wanted.to_bits(), "{} row {k}", record.name);
            }
        }
    }
}

/// Positions logged at a quarter of the targets' rate count as readings in a quarter of the rows. Positions
/// that lack every fourth row count in three quarters. The values between readings are unknown.
#[test]
fn truth_positions_with_fewer_rows_than_targets_have_no_readings_between_their_own() {
    let kept: [fn(usize) -> bool; 2] = [|k| k % 4 == 0, |k| k % 4 != 2];
    for is_kept in kept {
        let folder = tempfile::tempdir().expect("a folder");
        two_joints(folder.path());
        let state = folder.path().join("state.csv");
        let text = fs::read_to_string(&state).expect("it is there");
        let lines = text.lines().enumerate().filter(|(i, _)| i.checked_sub(1).is_none_or(is_kept));
        fs::write(&state, lines.fold(String::new(), |text, (_, line)| text + line + "\n")).expect("written");
        let machine = folder.path().join("machine.toml");
        fs::write(&machine, MACHINE).expect("written");
        let out = folder.path().join("knee");
        let options = Options {
            out: Some(out.clone()),
            joint: Some("knee".into()),
            model: Some(Model::Machine(machine)),
            ..Options::default()
        };
        import(&[folder.path()], &options, &|_| ()).expect("a dataset");
        let dataset = Dataset::load(&out).expect("it is sound");
        let record = &dataset.records[0];
        let read: Vec<usize> = (0..record.len()).filter(|&k| !record.bridged[0][k]).collect();
        assert_eq!(read, (0..1500).filter(|&k| is_kept(k)).collect::<Vec<_>>());
    }
}

#[test]
fn reference_a_real_arm_is_surveyed_from_its_folder_as_it_lies() {
    let data = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/so101");
    if !data.is_dir() {
        let _ = writeln!(std::io::stderr(), "skipped: {} is absent", data.display());
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let options = Options {
        out: Some(folder.path().join("elbow")),
        joint: Some("elbow_flex".into()),
        model: Some(Model::Mjcf(data.join("so101.xml"))),
        ..Options::default()
    };
    let runs = [data.join("multisine"), data.join("pick_place")];
    let paths: Vec<&Path> = runs.iter().map(PathBuf::as_path).collect();
    let survey = import(&paths, &options, &|_| ()).expect("a survey");
    assert_eq!(survey.runs.len(), 2);
    assert_eq!(survey.datasets[0].experiments, ["multisine.csv", "pick_place.csv"]);
    // By the peak of numpy.corrcoef over the same shifts, linear between readings.
    let follow = survey.joints["Elbow"].follow.expect("it follows");
    assert!((follow.lag_s - 0.175).abs() < 0.005, "{follow:?}");
    assert!((follow.correlation - 0.9127).abs() < 1e-3, "{follow:?}");
    let machine = fs::read_to_string(folder.path().join("elbow/machine.toml")).expect("written");
    // so101.xml: the class sts3215, and the force range of the joint's own actuator.
    for stated in ["limit = 3.35", "damping = 0.6", "0.052", "armature 0.028", "\"actuators.servo.kp\" = 0.5"]
    {
        assert!(machine.contains(stated), "{stated}: {machine}");
    }
    // so101.xml states 998.22, which disagrees with every error of this servo under load. The `kp` of the
    // machine file is the load over the error, by least squares.
    let kp =
        machine.lines().find_map(|line| line.strip_prefix("kp = ")).and_then(|kp| kp.parse::<f64>().ok());
    let (mut load_load, mut load_error) = (0.0, 0.0);
    for run in ["multisine", "pick_place"] {
        let rows = fs::read_to_string(folder.path().join(format!("elbow/{run}.csv"))).expect("written");
        for row in rows.lines().skip(1) {
            let cells: Vec<f64> = row.split(',').filter_map(|cell| cell.parse().ok()).collect();
            let [_, target, position, .., load] = cells[..] else { panic!("{row}") };
            load_load += load * load;
            load_error += load * (target - position);
        }
    }
    // Roundings of sums of 1e4 terms.
    assert!((kp.expect("a gain") / (load_load / -load_error) - 1.0).abs() < 1e-10, "{machine}");
    let rows = fs::read_to_string(folder.path().join("elbow/multisine.csv")).expect("written");
    // A header and the 6000 rows of the record.
    assert_eq!(rows.lines().count(), 6001);
    // Computed by mj_inverse of MuJoCo 4.0.0 on so101.xml without geometry, armature and friction, with a
    // gravity of 9.80665 m/s2. The motion comes from parabolas through rows 2996 to 3004 (numpy.polyfit). The
    // acceleration of the elbow is omitted.
    let load = rows.lines().nth(3001).and_then(|row| row.rsplit(',').next()?.parse::<f64>().ok());
    // Roundings of two ways through the same sums of some ten terms.
    assert!((load.expect("a load") - 0.402_252_322_641_361_2).abs() < 1e-12, "{load:?}");
    let dataset = Dataset::load(&folder.path().join("elbow")).expect("it is sound");
    assert_eq!(dataset.drives.len(), 2);
}

#[test]
fn truth_the_load_on_a_joint_is_its_weight_and_what_the_other_joint_does() {
    let folder = tempfile::tempdir().expect("a folder");
    // A link of 2 kg, its centre 0.5 m out; one of 1 kg hangs on its end, 0.3 m out. Both turn about y.
    let model = r#"<mujoco><compiler angle="radian"/><worldbody><body name="thigh">
        <joint name="hip" axis="0 1 0" damping="1"/>
        <inertial pos="0.5 0 0" mass="2" diaginertia="0.01 0.01 0.01"/>
        <body name="shank" pos="1 0 0"><joint name="knee" axis="0 1 0" damping="1"/>
        <inertial pos="0.3 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body></body></worldbody></mujoco>"#;
    let path = folder.path().join("arm.xml");
    fs::write(&path, model).expect("written");
    // Both joints speed up steadily, so that the parabolas of the import are exact.
    let (mut log, hip, knee) = ("t_s,hip_target,hip_pos,knee_target,knee_pos\n".to_owned(), 0.2, -0.3);
    for k in 0..200 {
        let t = f64::from(k) * 0.01;
        let _ = writeln!(log, "{t},{},{},{},{}", hip * t, hip * t * t, knee * t, knee * t * t);
    }
    fs::write(folder.path().join("log.csv"), log).expect("written");
    let out = folder.path().join("out");
    let options = Options { out: Some(out.clone()), model: Some(Model::Mjcf(path)), ..Options::default() };
    import(&[&folder.path().join("log.csv")], &options, &|_| ()).expect("two datasets");
    let rows = fs::read_to_string(out.join("knee/log.csv")).expect("written");
    let loads = rows.lines().skip(1).filter_map(|row| row.rsplit(',').next()?.parse::<f64>().ok());
    let mut seen = 0;
    for (k, load) in loads.enumerate() {
        let t = 0.01 * k as f64;
        let (a, b) = (hip * t * t, knee * t * t);
        let (speed, acceleration) = (2.0 * hip * t, 2.0 * hip);
        // Lagrange: the knee's share of the hip's acceleration, the centrifugal force of the hip's speed, and
        // the weight; turning about +y lowers the tip.
        let coupled = (0.3_f64.powi(2) + 0.01 + 0.3 * b.cos()) * acceleration;
        let effort = coupled + 0.3 * b.sin() * speed.powi(2) - 9.806_65 * 0.3 * (a + b).cos();
        // The parabola's curvature has the roundings of positions up to 1.2 over the square of 80 ms.
        assert!((load + effort).abs() < 1e-9, "{load} {effort} at {t} s");
        seen += 1;
    }
    assert_eq!(seen, 200);
}

/// A log of joints with targets and positions, and a serial arm whose URDF lists its joints from the tip.
fn arm_log(folder: &Path, logged: &[&str], joints: &[&str]) -> (PathBuf, PathBuf) {
    let header: Vec<String> = logged.iter().map(|name| format!("{name}_target,{name}_pos")).collect();
    let mut log = format!("t_s,{}\n", header.join(","));
    for k in 0..200 {
        let t = f64::from(k) * 0.01;
        let cells: Vec<String> = (0..logged.len())
            .map(|i| {
                let wave = |t: f64| 0.4 * ((3.0 + i as f64) * t).sin();
                format!("{},{}", wave(t), wave(t - 0.03))
            })
            .collect();
        let _ = writeln!(log, "{t},{}", cells.join(","));
    }
    let mut urdf = String::from("<robot name=\"arm\"><link name=\"link0\"/>");
    for i in 0..joints.len() {
        let _ = write!(
            urdf,
            "<link name=\"link{}\"><inertial><mass value=\"0.1\"/><inertia ixx=\"1e-4\" ixy=\"0\" ixz=\"0\" \
             iyy=\"1e-4\" iyz=\"0\" izz=\"1e-4\"/></inertial></link>",
            i + 1
        );
    }
    for (i, name) in joints.iter().enumerate().rev() {
        let _ = write!(
            urdf,
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"link{i}\"/><child link=\"link{}\"/>\
             <origin xyz=\"0.1 0 0\"/><axis xyz=\"0 0 1\"/></joint>",
            i + 1
        );
    }
    urdf.push_str("</robot>");
    let paths = (folder.join("log.csv"), folder.join("arm.urdf"));
    fs::write(&paths.0, log).expect("written");
    fs::write(&paths.1, urdf).expect("written");
    paths
}

/// Lines of the import about joints, each by its name in the log.
fn said_of_joints(logged: &[&str], joints: &[&str]) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let (log, urdf) = arm_log(folder.path(), logged, joints);
    let out = Some(folder.path().join("out"));
    let options = Options { out, model: Some(Model::Urdf(urdf)), ..Options::default() };
    let survey = import(&[&log], &options, &|_| ()).expect("datasets");
    survey.datasets.iter().map(|dataset| dataset.assumptions.join("\n")).collect()
}

/// The names of the SO-101 arm, whose URDF begins with the gripper.
#[test]
fn regress_joints_of_a_urdf_that_begins_at_the_tip_are_found_by_name_and_order() {
    let logged = ["Rotation", "Pitch", "Elbow", "Wrist_Pitch", "Wrist_Roll", "Jaw"];
    let joints = ["shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper"];
    let said = said_of_joints(&logged, &joints);
    assert_eq!(said.len(), 6);
    for ((said, name), joint) in said.iter().zip(logged).zip(joints) {
        let expected = format!("`{}` is the joint `{joint}` of the model", name.to_lowercase());
        assert!(said.contains(&expected), "{expected}: {said}");
    }
}

#[test]
fn regress_no_joint_is_found_by_its_place_where_a_name_contradicts() {
    let said = said_of_joints(&["elbow", "first", "second"], &["base", "elbow_flex", "tip"]);
    assert!(said[0].contains("`elbow` is the joint `elbow_flex`"), "{}", said[0]);
    for (said, name) in said[1..].iter().zip(["first", "second"]) {
        assert!(said.contains(&format!("the model has no joint `{name}`")), "{said}");
    }
}

/// A torque, and a current whose force per ampere is unknown.
#[test]
fn regress_a_logged_torque_command_is_a_force_and_no_target() {
    let stated = |role: ColumnRole, column: &str| (role, column.to_owned());
    for (command, said) in [
        ("knee_tau_cmd", "the command is the force of the drive"),
        ("knee_current_cmd", "the command is a current"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let mut log = format!("t_s,{command},knee_pos\n");
        for k in 0..400 {
            let t = f64::from(k) * 0.01;
            let _ = writeln!(log, "{t},{},{}", -1.8 * (3.0 * t).sin(), 0.2 * (3.0 * t).sin());
        }
        let path = folder.path().join("log.csv");
        fs::write(&path, log).expect("written");
        let both = vec![stated(ColumnRole::Command, command), stated(ColumnRole::Position, "knee_pos")];
        for (i, columns) in [Vec::new(), both].into_iter().enumerate() {
            let out = folder.path().join(format!("out{i}"));
            let options = Options { out: Some(out.clone()), columns, ..Options::default() };
            let survey = import(&[&path], &options, &|_| ()).expect("a dataset");
            let assumed = survey.datasets[0].assumptions.join(" ");
            assert!(assumed.contains(said), "{assumed}");
            let dataset = Dataset::load(&out).expect("it is sound");
            let driven = &dataset.drives[0];
            assert_eq!(driven.column, "command");
            assert!(matches!(dataset.machine.actuators[driven.drive].kind, ActuatorKind::Force { .. }));
        }
    }
}

/// A clock that starts again is another recording. One that goes back or stands still is refused with its
/// row, and only listed while nothing is written.
#[test]
fn regress_a_clock_that_goes_back_is_cut_or_refused_and_never_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let again: fn(usize) -> f64 = |k| if k < 160 { 0.01 * k as f64 } else { 0.01 * (k - 160) as f64 };
    let back: fn(usize) -> f64 = |k| if k < 160 { 0.01 * k as f64 } else { 0.01 * k as f64 - 0.5 };
    let still: fn(usize) -> f64 = |k| 0.01 * if k == 160 { 159.0 } else { k as f64 };
    for (name, time, said) in [
        ("again", again, None),
        ("back", back, Some("row 162: the clock `t_s` goes back")),
        ("still", still, Some("row 162: the clock `t_s` does not advance")),
    ] {
        let mut log = "t_s,knee_target,knee_pos\n".to_owned();
        for k in 0..300 {
            let (t, at) = (time(k), 0.01 * k as f64);
            let _ = writeln!(log, "{t},{},{}", (3.0 * at).sin(), (3.0 * at - 0.1).sin());
        }
        let path = folder.path().join(format!("{name}.csv"));
        fs::write(&path, log).expect("written");
        let listed = import(&[&path], &Options::default(), &|_| ()).expect("a survey");
        assert_eq!(listed.runs[0].tables[0].back_in_row, (name == "back").then_some(162));
        let out = folder.path().join(name);
        let options = Options { out: Some(out.clone()), ..Options::default() };
        match (import(&[&path], &options, &|_| ()), said) {
            (Ok(survey), None) => {
                assert_eq!(survey.datasets[0].experiments, ["again-1.csv", "again-2.csv"]);
                assert!(survey.runs[0].notes[0].contains("starts again in row 162"));
                let dataset = Dataset::load(&out).expect("it is sound");
                assert_eq!(dataset.records.iter().map(Record::len).collect::<Vec<_>>(), [160, 140]);
            }
            (Err(error), Some(said)) => {
                assert!(error.to_string().contains(said) && error.remedy().contains("sort"), "{error}");
                assert!(!out.join("dataset.toml").exists());
            }
            (other, _) => panic!("{name}: {:?}", other.map(|survey| survey.datasets)),
        }
    }
}

#[test]
fn regress_names_of_a_joint_pair_however_their_number_is_set_apart() {
    for position in ["position[j0]", "j_0_pos", "J0.pos"] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log.csv");
        let mut log = format!("t_s,j0_target,{position}\n");
        for k in 0..100 {
            let t = f64::from(k) * 0.01;
            let _ = writeln!(log, "{t},{},{}", (3.0 * t).sin(), (3.0 * t - 0.1).sin());
        }
        fs::write(&path, log).expect("written");
        let survey = import(&[&path], &Options::default(), &|_| ()).expect("a survey");
        let whole = survey.joints.values().filter(|guess| guess.follow.is_some()).count();
        assert_eq!((whole, survey.joints.len()), (1, 1), "{position}: {:?}", survey.joints.keys());
    }
}

#[test]
fn regress_files_without_numbers_and_models_of_another_sort_are_refused_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("written");
        path
    };
    for (name, bytes, said) in [
        ("words.txt", &b"one\ntwo\nthree\n"[..], "no rows of numbers"),
        ("a.jpg", b"\xff\xd8\xff\xe0....", "picture"),
        ("a.yaml", b"a: 1\n", "YAML"),
        ("a.obj", b"v 1 2 3\nv 1 2 4\n", "mesh"),
    ] {
        let error = import(&[&file(name, bytes)], &Options::default(), &|_| ()).expect_err(name);
        assert!(error.to_string().contains(said) && !error.remedy().is_empty(), "{error}");
    }
    let (log, urdf) = arm_log(folder.path(), &["a"], &["a"]);
    for (model, said) in [
        (Model::Mjcf(urdf), "this is a URDF"),
        (Model::Urdf(file("m.xml", b"<mujoco/>")), "this is an MJCF model"),
        (Model::Mjcf(file("x.toml", b"a = 1\n")), "this is not XML"),
        (Model::Urdf(file("latin.urdf", b"<robot>\n<!-- \xe4 -->")), "line 2: byte 13 is not UTF-8"),
    ] {
        let options =
            Options { out: Some(folder.path().join("out")), model: Some(model), ..Options::default() };
        let error = import(&[&log], &options, &|_| ()).expect_err(said);
        assert!(error.to_string().contains(said) && !error.remedy().is_empty(), "{error}");
    }
}
