//! A real servo joint: the elbow of an SO-101, as its users log it, against motions that are not fitted.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::import::{Model, Options, import};
use feeler_diagnosis::replay::replay;
use feeler_diagnosis::{Budget, diagnose_within};

/// Motions that are fitted.
const FITTED: [&str; 2] = ["multisine", "pick_place"];
/// Motions that are not, with the rms error of the elbow that nominal MuJoCo leaves there, rad (README of the
/// data: `so101.xml` with the servo's published values, targets as recorded).
const HELD: [(&str, f64); 2] = [("chirp_sweep", 61.1e-3), ("friction_gravity", 36.7e-3)];
/// Calibration takes a sixth of it, and some seconds here.
const BUDGET: Duration = Duration::from_secs(40);

#[test]
fn reference_a_diagnosis_of_a_real_joint_predicts_motions_that_it_did_not_fit() {
    let data = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/so101");
    if !data.is_dir() {
        let _ = writeln!(std::io::stderr(), "skipped: {} is absent", data.display());
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("elbow");
    let options = Options {
        out: Some(out.clone()),
        joint: Some("elbow_flex".into()),
        model: Some(Model::Mjcf(data.join("so101.xml"))),
        ..Options::default()
    };
    let runs: Vec<PathBuf> =
        FITTED.into_iter().chain(HELD.map(|(name, _)| name)).map(|name| data.join(name)).collect();
    let paths: Vec<&Path> = runs.iter().map(PathBuf::as_path).collect();
    import(&paths, &options, &|_| ()).expect("a dataset");
    let file = out.join("dataset.toml");
    let mut text = fs::read_to_string(&file).expect("written");
    for (names, role) in [(FITTED, "fit"), (HELD.map(|(name, _)| name), "check")] {
        for name in names {
            let line = format!("file = \"{name}.csv\"");
            text = text.replace(&line, &format!("{line}\nrole = \"{role}\""));
        }
    }
    fs::write(&file, text).expect("written");
    let dataset = Dataset::load(&out).expect("it is sound");
    let answer = diagnose_within(&dataset, Budget::of(BUDGET), &|_| {}).expect("an answer");
    // The gap is that of the motions that were not fitted.
    assert!(answer.gap.refit < 0.75 * answer.gap.before, "{:?}", answer.gap);
    assert!(answer.gap.after <= 1.05 * answer.gap.refit, "{:?}", answer.gap);
    let errors = |machine| -> Vec<f64> {
        let replays = replay(machine, &dataset).expect("a motion");
        let of = |name: &str| replays.iter().find(|found| found.experiment.contains(name));
        HELD.iter().map(|(name, _)| of(name).expect("it is there").errors[0].rms).collect()
    };
    let (believed, found) = (errors(&dataset.machine), errors(&answer.calibrated));
    for (i, (name, of_mujoco)) in HELD.iter().enumerate() {
        let (found, believed) = (found[i], believed[i]);
        let said = format!("{name}: {found} rad, believed {believed} rad, nominal MuJoCo {of_mujoco} rad");
        assert!(found < believed && found < *of_mujoco, "{said}");
    }
}
