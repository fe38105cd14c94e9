//! Real servo joints: those of an SO-101, as its users log it, against motions that are not fitted.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::import::{Model, Options, import};
use feeler_diagnosis::replay::replay;
use feeler_diagnosis::report::Verdict;
use feeler_diagnosis::{Budget, Diagnosis, diagnose_within};
use feeler_plant::description::Machine;

/// Motions that are fitted.
const FITTED: [&str; 2] = ["multisine", "pick_place"];
/// Motions that are not, with the rms error of the elbow that nominal MuJoCo leaves there, rad (README of the
/// data: `so101.xml` with the servo's published values, targets as recorded).
const HELD: [(&str, f64); 2] = [("chirp_sweep", 61.1e-3), ("friction_gravity", 36.7e-3)];
/// Calibration takes a sixth of it, and some seconds here.
const BUDGET: Duration = Duration::from_secs(40);
/// Joints with a motion in which they move alone.
const ALONE: [(&str, &str); 4] = [
    ("shoulder_pan", "single_joint_rotation"),
    ("elbow_flex", "single_joint_elbow"),
    ("wrist_flex", "single_joint_wrist_pitch"),
    ("wrist_roll", "single_joint_wrist_roll"),
];
/// For each of them.
const BUDGET_ALONE: Duration = Duration::from_secs(8);

/// The folder of the data; `None` with a message if they are absent.
fn data() -> Option<PathBuf> {
    let data = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/so101");
    if !data.is_dir() {
        let _ = writeln!(std::io::stderr(), "skipped: {} is absent", data.display());
        return None;
    }
    Some(data)
}

/// The dataset of a joint, imported with the servo's published values.
fn imported(data: &Path, joint: &str, fitted: &[&str]) -> Dataset {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join(joint);
    let options = Options {
        out: Some(out.clone()),
        joint: Some(joint.into()),
        model: Some(Model::Mjcf(data.join("so101.xml"))),
        ..Options::default()
    };
    let held = HELD.map(|(name, _)| name);
    let runs: Vec<PathBuf> = fitted.iter().chain(&held).map(|name| data.join(name)).collect();
    let paths: Vec<&Path> = runs.iter().map(PathBuf::as_path).collect();
    import(&paths, &options, &|_| ()).expect("a dataset");
    let file = out.join("dataset.toml");
    let mut text = fs::read_to_string(&file).expect("written");
    for (names, role) in [(fitted, "fit"), (&held, "check")] {
        for name in names {
            let line = format!("file = \"{name}.csv\"");
            text = text.replace(&line, &format!("{line}\nrole = \"{role}\""));
        }
    }
    fs::write(file, text).expect("written");
    Dataset::load(&out).expect("it is sound")
}

/// Root mean square errors of free runs over the motions that were not fitted, rad.
fn errors(machine: &Machine, dataset: &Dataset) -> Vec<f64> {
    let replays = replay(machine, dataset).expect("a motion");
    let of = |name: &str| replays.iter().find(|found| found.experiment.contains(name));
    HELD.iter().map(|(name, _)| of(name).expect("it is there").errors[0].rms).collect()
}

/// Asserts that an answer is unsure, and says how far off it is. The causes of this arm's gap are unknown.
fn is_modest(answer: &Diagnosis) {
    let said = (answer.verdict, &answer.effects, &answer.adequacy.shortfalls);
    assert!(matches!(answer.verdict, Verdict::Ambiguous | Verdict::UnknownCause), "{said:?}");
    assert!(answer.effects.iter().all(|effect| effect.probability < 0.9), "{said:?}");
    assert!(!answer.adequacy.shortfalls.is_empty(), "{said:?}");
    let is_measured = |error: Option<f64>| error.is_some_and(f64::is_finite);
    assert!(answer.adequacy.horizons.iter().all(|horizon| is_measured(horizon.after)), "{said:?}");
}

#[test]
fn reference_a_diagnosis_of_a_real_joint_predicts_motions_that_it_did_not_fit() {
    let Some(data) = data() else { return };
    let dataset = imported(&data, "elbow_flex", &FITTED);
    let answer = diagnose_within(&dataset, Budget::of(BUDGET), &|_| {}).expect("an answer");
    is_modest(&answer);
    // The gap is that of the motions that were not fitted.
    assert!(answer.gap.refit < 0.75 * answer.gap.before, "{:?}", answer.gap);
    assert!(answer.gap.after <= 1.05 * answer.gap.refit, "{:?}", answer.gap);
    let of = |machine: &Machine| errors(machine, &dataset);
    let (believed, found, proposed) = (of(&dataset.machine), of(&answer.calibrated), of(&answer.machine));
    for (i, (name, of_mujoco)) in HELD.iter().enumerate() {
        let (found, believed) = (found[i], believed[i]);
        let said = format!("{name}: {found} rad, believed {believed} rad, nominal MuJoCo {of_mujoco} rad");
        assert!(found < believed && found < *of_mujoco, "{said}");
        // An unsure answer may propose the believed machine, but none that runs worse.
        assert!(proposed[i] <= believed, "{said}, proposed {}", proposed[i]);
    }
}

/// One motion of one joint says too little for a sure answer. What is proposed must not be worse over the
/// motions that were not fitted.
#[test]
fn reference_a_joint_that_moved_alone_is_answered_modestly() {
    let Some(data) = data() else { return };
    for (joint, motion) in ALONE {
        let dataset = imported(&data, joint, &[motion]);
        let answer = diagnose_within(&dataset, Budget::of(BUDGET_ALONE), &|_| {}).expect("an answer");
        is_modest(&answer);
        let all = |machine: &Machine| errors(machine, &dataset).iter().map(|x| x * x).sum::<f64>().sqrt();
        let (believed, proposed) = (all(&dataset.machine), all(&answer.machine));
        assert!(proposed <= 1.001 * believed, "{joint}: {proposed} rad, believed {believed} rad");
    }
}
