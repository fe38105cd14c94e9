//! Scenarios of a whole arm: their results, the agreement with their reduced axis, and rejected input.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests fail as tests do, and say what they measured"
)]

use std::path::{Path, PathBuf};

use feeler_arm::Others;
use feeler_files::{ArmFile, CellFile, Document, Draft, cell_schema};
use feeler_studies::arm::{ToolContact, axis_file};
use feeler_studies::run::{CellRun, Outcome, Undecided, run, run_cell};

fn arms() -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join("arms")
}

fn load(file: &str, settings: &[&str]) -> CellFile {
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    let draft = Draft::load_with(&arms().join(file), &settings).unwrap_or_else(|error| panic!("{error}"));
    CellFile::build(draft).unwrap_or_else(|error| panic!("{error}"))
}

fn go(file: &CellFile) -> CellRun {
    run_cell(file, &mut |_| {}).unwrap()
}

/// Settings that remove the dry friction of the joints.
const SMOOTH: [&str; 6] = [
    "joints.pan.dry_friction=0",
    "joints.lift.dry_friction=0",
    "joints.elbow.dry_friction=0",
    "joints.bend.dry_friction=0",
    "joints.swivel.dry_friction=0",
    "joints.roll.dry_friction=0",
];

/// The settling band: 2 % of 20 N.
const SETTLED_N: f64 = 0.4;

/// At 3 mm/s the tool does not reach the workpiece in 0.6 s. A thrown tool arrives after the end of the run.
#[test]
fn regress_an_arm_on_its_way_has_not_missed_the_workpiece() {
    for (file, settings) in [
        ("press-low-gain.toml", &["controllers.force.approach.speed=0.003", "run.duration=0.6"][..]),
        ("impact.toml", &["run.duration=0.01"]),
    ] {
        let verdict = go(&load(file, settings)).summary.figures.verdict;
        assert_eq!(verdict.undecided, Some(Undecided::StillApproaching), "{file}: {verdict:?}");
    }
}

/// A tool that leaves a workpiece with its drives idle comes back only where something pushes it: a load on a
/// joint does so within half a second.
#[test]
fn regress_a_load_on_a_joint_brings_a_tool_back() {
    let loaded = "joints.lift.effects.constant-load={ force = 2 }";
    let of = |settings: &[&str]| go(&load("impact.toml", settings)).summary.figures;
    let [free, pushed] = [of(&[]), of(&[loaded])];
    assert_eq!([free.bounces, pushed.bounces], [1, 1]);
    assert_eq!([free.verdict.outcome, pushed.verdict.outcome], [Outcome::NoContact, Outcome::Undecided]);
    assert_eq!(pushed.verdict.undecided, Some(Undecided::StillApproaching));
    let later = of(&[loaded, "run.duration=0.6"]);
    let touches = later.events.iter().filter(|event| event.what == "touch").count();
    assert!(touches > 1, "{touches}");
}

#[test]
fn prop_the_same_file_and_seed_give_the_same_bits() {
    let of = || go(&load("press-low-gain.toml", &["run.duration=0.4"]));
    let [a, b] = [of(), of()];
    assert_eq!(a.record, b.record);
    // The rate of the file is a tenth of the rate of the measures.
    assert_eq!(
        a.motion.column("tool.force").unwrap()[7].to_bits(),
        a.record.column("tool.force").unwrap()[70].to_bits()
    );
}

/// Peak force of an impact.
const IMPACT: f64 = 0.05;

#[test]
fn reference_the_reduced_axis_has_the_arm_s_impact() {
    for (x, y, hold) in [(0.65, 0.1, 0), (0.5, -0.3, 0), (0.65, 0.1, 4)] {
        let place = [
            format!("start.place=[{x}, {y}, 0.077]"),
            format!("workpiece.x={x}"),
            format!("workpiece.y={y}"),
            format!("hold.bandwidth={hold}"),
        ];
        let settings: Vec<&str> = place.iter().map(String::as_str).collect();
        let file = load("impact.toml", &settings);
        let whole = go(&file).summary.figures.peak_force_n;
        let cell = &file.cell;
        let arm =
            ArmFile { name: "arm".into(), about: String::new(), arm: cell.arm.clone(), doubts: Vec::new() };
        let contact = cell.scenario.machine.contacts.values().next().unwrap();
        let contact = ToolContact {
            stiffness_n_per_m: contact.stiffness,
            damping_n_s_per_m: contact.damping_n_s_per_m,
        };
        let others = if cell.hold.bandwidth_hz > 0.0 { Others::Held } else { Others::Free };
        let axis = axis_file(&arm, &cell.start.pose, cell.start.normal, others, contact).unwrap();
        let mut scenario = Document::parse(&axis.text, "axis.toml").unwrap().scenario;
        scenario.controllers.clear();
        scenario.machine.contacts.values_mut().for_each(|contact| contact.gap_m = 1e-3);
        scenario
            .machine
            .bodies
            .values_mut()
            .for_each(|body| body.velocity_m_per_s = cell.start.speed_m_per_s);
        scenario.run.duration_s = cell.scenario.run.duration_s;
        scenario.run.record.clear();
        let reduced = run(&scenario, &mut |_| {}).unwrap().summary.peak_force_n;
        println!("at {x}, {y}, {others:?}: {whole:.3} N of the arm, {reduced:.3} N of its axis");
        assert!((reduced / whole - 1.0).abs() < IMPACT, "{reduced} {whole}");
    }
}

/// Tolerance relative to the force of three springs in series: the programmed one, gears and contact. The
/// other directions yield slightly.
const AT_REST: f64 = 0.02;

#[test]
fn truth_impedance_presses_as_springs_in_series_do_and_admittance_reaches_its_force() {
    let base = std::fs::read_to_string(arms().join("press-low-gain.toml")).unwrap();
    let (before, rest) = base.split_once("[controllers.force]").unwrap();
    let (_, after) = rest.split_once("[run]").unwrap();
    let with = |controller: &str| {
        let text = format!("{before}[controllers.force]\n{controller}\n[run]{after}");
        let mut draft = Draft::parse(&text, &arms().join("other.toml").display().to_string()).unwrap();
        for setting in SMOOTH {
            draft.set(setting).unwrap();
        }
        CellFile::build(draft).unwrap_or_else(|error| panic!("{error}"))
    };
    let impedance = with(
        "law = \"impedance\"\nstiffness = \"2 kN/m\"\ndamping = \"300 N s/m\"\nperiod = \"1 ms\"\nreference \
         = \"12 mm\"",
    );
    let found = go(&impedance).summary;
    let axis = impedance.cell.reduction().unwrap();
    // The gap is 2 mm.
    let expected = (12e-3 - 2e-3) / (1.0 / 2e3 + 1.0 / 2e4 + 1.0 / axis.static_stiffness_n_per_m);
    println!(
        "impedance: {:.3} N, {expected:.3} N by springs in series, {:?}",
        found.final_force_n, found.figures.outcome
    );
    assert!((found.final_force_n / expected - 1.0).abs() < AT_REST, "{} {expected}", found.final_force_n);
    let admittance = with(
        "law = \"admittance\"\nreads = \"force\"\nmass = \"4 kg\"\ndamping = \"1500 N s/m\"\nkp = \"20 \
         kN/m\"\nkd = \"600 N s/m\"\nperiod = \"1 ms\"\nreference = 20",
    );
    let found = go(&admittance).summary;
    println!("admittance: {:.3} N, {:?}", found.final_force_n, found.figures.outcome);
    assert!((found.final_force_n - 20.0).abs() < SETTLED_N, "{}", found.final_force_n);
}

const LEVER: &str = r#"<robot name="lever"><link name="base"/>
  <link name="rod"><inertial><mass value="2"/><inertia ixx="0.7" iyy="0.7" izz="0.7"/></inertial></link>
  <link name="tip"/>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint>
  <joint name="end" type="fixed"><parent link="rod"/><child link="tip"/><origin xyz="0.8 0 0"/></joint>
</robot>"#;

const LEVER_SCENARIO: &str = r#"
arm = "lever.urdf"
[joints.hinge]
gear_ratio = 100
rotor_inertia = 1.1e-4
stiffness = 3e4
damping = 25.0
[start]
pose = [0]
normal = [0, 0, -1]
speed = 0.05
[tip]
shape = "ball"
radius = 0.005
[workpiece]
shape = "cuboid"
half_x = 0.2
half_y = 0.2
half_z = 0.01
x = 0.8
z = -0.0151
[contacts.tool]
stiffness = 2e4
damping = 40.0
[controllers.none]
law = "open-loop"
period = "1 ms"
[run]
duration = 0.05
"#;

/// Tolerance of the axis. The lever turns by 2 mrad, so the tool's path bends by the same angle. Relative to
/// the point of contact, the ball's centre moves by this angle times its radius.
const LEVER_IS_AN_AXIS: f64 = 1e-4;

/// A folder with the lever and its scenario.
fn lever(urdf: &str, scenario: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lever.urdf"), urdf).unwrap();
    let path = folder.path().join("lever.toml");
    std::fs::write(&path, scenario).unwrap();
    (folder, path)
}

#[test]
fn truth_a_lever_from_a_urdf_is_two_masses() {
    let (_folder, path) = lever(LEVER, LEVER_SCENARIO);
    let file = CellFile::load(&path).unwrap_or_else(|error| panic!("{error}"));
    let whole = go(&file).summary.figures.peak_force_n;
    let text = "bodies.motor = { mass = 1.71875, velocity = 0.05 }
        bodies.tip = { mass = 1.09375, velocity = 0.05 }
        springs.gear = { between = [\"motor\", \"tip\"], stiffness = 46875.0, damping = 39.0625 }
        contacts.tool = { between = [\"tip\", \"ground\"], stiffness = 2e4, damping = 40.0, gap = 1e-4 }
        run.duration = 0.05";
    let axis =
        run(&Document::parse(text, "axis.toml").unwrap().scenario, &mut |_| {}).unwrap().summary.peak_force_n;
    println!("lever: {whole:.5} N, two masses: {axis:.5} N");
    assert!((whole / axis - 1.0).abs() < LEVER_IS_AN_AXIS, "{whole} {axis}");
}

/// The mistakes of a file, each as one line.
fn told(path: &Path) -> Vec<String> {
    CellFile::load(path).map(|_| ()).unwrap_err().problems.iter().map(ToString::to_string).collect()
}

/// Changes of the scenario, each with the key and a part of the one mistake that it makes.
const MISTAKES: [(&str, &str, &str, &str); 14] = [
    (
        "shape = \"cuboid\"\nhalf_x = 0.2\nhalf_y = 0.2\nhalf_z = 0.01\nx = 0.8",
        "shape = \"mesh\"\nfile = \"none.stl\"\nx = 0.8",
        "workpiece.file",
        "name an STL or OBJ",
    ),
    ("z = -0.0151", "z = -0.01", "start.pose", "inside the workpiece (move the start back"),
    ("z = -0.0151", "z = -0.0151\ny = 0.5", "start.normal", "never meets the workpiece (turn the normal"),
    ("normal = [0, 0, -1]", "normal = [1, 0, 0]", "start.normal", "cannot move along the normal"),
    ("z = -0.0151", "z = -0.9", "workpiece", "does not reach"),
    ("pose = [0]", "place = [3, 0, 0]", "start.place", "no pose within the joint limits"),
    ("pose = [0]", "", "start", "either `pose` or `place` (give"),
    ("arm = \"lever.urdf\"", "arm = \"arm.toml\"", "arm", "name an arm file or a URDF"),
    (
        "stiffness = 3e4",
        "stiffness = 3e4\neffects.added-mass.mass = 1.0",
        "joints.hinge.effects.added-mass",
        "joints take",
    ),
    (
        "[contacts.tool]",
        "[contacts.tool]\nbetween = [\"a\", \"b\"]",
        "contacts.tool.between",
        "no meaning for a whole arm",
    ),
    (
        "[controllers.none]",
        "[controllers.more]\nlaw = \"open-loop\"\nperiod = \"1 ms\"\n[controllers.none]",
        "controllers",
        "one controller",
    ),
    ("duration = 0.05", "duration = 0.05\nstep = \"20 ms\"", "run.step", "too long for the fastest mode"),
    ("duration = 0.05", "duration = 0.05\nengine = \"rapier\"", "run.engine", "no meaning for a whole arm"),
    ("[tip]", "[bodies.x]\nmass = 1\n[tip]", "bodies", "there is no key"),
];

#[test]
fn truth_every_mistake_is_one_error_with_file_key_and_remedy() {
    for (from, to, key, part) in MISTAKES {
        assert!(LEVER_SCENARIO.contains(from), "{from}");
        let (_folder, path) = lever(LEVER, &LEVER_SCENARIO.replacen(from, to, 1));
        let problems = told(&path);
        assert_eq!(problems.len(), 1, "{key}: {problems:#?}");
        println!("{}", problems[0]);
        assert!(
            problems[0].contains("lever.toml")
                && problems[0].contains(&format!(": {key}: "))
                && problems[0].contains(part),
            "{key}: {}",
            problems[0]
        );
    }
    let (_folder, path) = lever(&LEVER.replace("izz=\"0.7\"", "izz=\"0\""), LEVER_SCENARIO);
    let problems = told(&path);
    assert!(
        problems.len() == 1 && problems[0].contains("inertia of 0 kg m2") && problems[0].contains("line 2"),
        "{problems:#?}"
    );
}

#[test]
fn truth_an_arm_that_starts_in_itself_or_in_the_workpiece_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(arms().join("press-low-gain.toml")).unwrap();
    let folded = text.replace(
        "place  = [\"0.65 m\", \"0.1 m\", \"0.078 m\"]",
        "pose = [0, \"-69 deg\", \"157 deg\", \"166 deg\", 0, 0]",
    );
    let path = folder.path().join("folded.toml");
    for file in ["six-joint.toml", "six-joint.urdf", "dome.obj"] {
        std::fs::copy(arms().join(file), folder.path().join(file)).unwrap();
    }
    std::fs::write(&path, folded).unwrap();
    let problems = told(&path);
    println!("{problems:#?}");
    assert!(
        problems.len() == 1
            && problems[0].contains("start.pose")
            && problems[0].contains("runs") | problems[0].contains("run into itself")
    );
}

#[test]
fn truth_other_commands_point_to_the_axis() {
    let error = Document::load(&arms().join("press-low-gain.toml")).unwrap_err().to_string();
    assert!(error.contains("whole arm") && error.contains("feeler reduce"), "{error}");
}

#[test]
fn truth_the_schema_has_every_table() {
    let schema = cell_schema();
    for table in
        ["arm", "start", "tip", "workpiece", "hold", "joints", "contacts", "sensors", "controllers", "run"]
    {
        assert!(!schema["properties"][table].is_null(), "{table}");
    }
    let joint = &schema["properties"]["joints"]["additionalProperties"];
    assert!(joint["properties"]["effects"]["properties"]["backlash"].is_object());
}
