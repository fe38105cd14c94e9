//! Joints of a real industrial arm as single axes. The arm moves all joints at once, so one axis cannot
//! explain a joint.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::report::Verdict;
use feeler_diagnosis::{Budget, diagnose_within};

/// Gear ratio of each joint (README of the data), and published inertia, damping and dry friction, on the
/// joint's side.
const JOINTS: [(f64, [f64; 3]); 3] =
    [(32.0, [1.27, 8.03, 7.23]), (32.0, [1.07, 5.52, 8.25]), (45.0, [0.207, 2.00, 6.29])];
/// Rows that are averaged into one, and their spacing.
const AVERAGED: usize = 20;
const SPACING_S: f64 = 4e-3;
const BUDGET: Duration = Duration::from_secs(20);

/// One column of a table of the data, averaged.
fn column(path: &Path, joint: usize) -> Vec<f64> {
    let text = fs::read_to_string(path).expect("it is there");
    let number = |line: &str| line.split(',').nth(joint).and_then(|cell| cell.trim().parse().ok());
    let rows: Vec<f64> = text.lines().skip(1).map(|line| number(line).expect("a number")).collect();
    rows.chunks_exact(AVERAGED).map(|rows| rows.iter().sum::<f64>() / AVERAGED as f64).collect()
}

/// The dataset of a joint: its motor's torque and angle, on the joint's side.
fn dataset(data: &Path, joint: usize, friction: bool) -> Dataset {
    let (ratio, [inertia, damping, level]) = JOINTS[joint];
    let folder = tempfile::tempdir().expect("a folder");
    let torques = column(&data.join("curr_data.csv"), joint);
    let angles = column(&data.join("pos_read_data.csv"), joint);
    let mut rows = "t_s,torque_nm,angle_rad\n".to_owned();
    for (k, (torque, angle)) in torques.iter().zip(&angles).enumerate() {
        let _ = writeln!(rows, "{},{},{}", k as f64 * SPACING_S, torque * ratio, angle / ratio);
    }
    let mut machine = format!(
        "axis = \"rotational\"\n[bodies.link]\nmass = {inertia}\n[springs.guide]\n\
         between = [\"ground\", \"link\"]\ndamping = {damping}\n"
    );
    if friction {
        let _ = writeln!(machine, "[springs.guide.effects.coulomb-friction]\nlevel = {level}");
    }
    machine.push_str(
        "[actuators.drive]\non = \"link\"\nkind = \"force\"\n[sensors.encoder]\nreads = \"link.position\"\n",
    );
    let dataset = "machine = \"machine.toml\"\n[columns.torque_nm]\nsignal = \"drive.command\"\n\
                   [columns.angle_rad]\nsignal = \"encoder.reading\"\n[[experiments]]\nfile = \"run.csv\"\n";
    for (name, text) in [("run.csv", rows.as_str()), ("machine.toml", &machine), ("dataset.toml", dataset)] {
        fs::write(folder.path().join(name), text).expect("written");
    }
    Dataset::load(folder.path()).unwrap_or_else(|error| panic!("{error}")).in_pieces()
}

/// Joint 1 is coupled least, joints 2 and 3 also carry weight.
#[test]
fn reference_a_joint_of_a_moving_arm_is_not_explained_by_a_single_axis() {
    let data = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/tx40");
    if !data.is_dir() {
        let _ = writeln!(std::io::stderr(), "skipped: {} is absent", data.display());
        return;
    }
    for (joint, friction) in [(0, false), (0, true), (1, true), (2, true)] {
        let dataset = dataset(&data, joint, friction);
        assert!(dataset.warnings.iter().all(|fault| !fault.kind.is_contradiction()));
        let answer = diagnose_within(&dataset, Budget::of(BUDGET), &|_| {}).expect("an answer");
        let said = (answer.verdict, &answer.effects, &answer.adequacy.shortfalls);
        let is_unsure = matches!(answer.verdict, Verdict::Ambiguous | Verdict::UnknownCause);
        assert!(is_unsure, "joint {}: {said:?}", joint + 1);
        assert!(answer.effects.iter().all(|effect| effect.probability < 0.9), "{said:?}");
        // The answer states how far off it is.
        assert!(!answer.adequacy.shortfalls.is_empty() && !answer.adequacy.horizons.is_empty(), "{said:?}");
    }
}
