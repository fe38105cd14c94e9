//! A real drive: the electro-mechanical positioning system of Janot, Gautier and Brunot (2019), with
//! independently published figures.

use std::io::Write as _;
use std::path::Path;

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::diagnose;
use feeler_diagnosis::report::Verdict;
use feeler_plant::effects::Kind;

/// Published Coulomb level, and its tolerance.
const LEVEL_N: (f64, f64) = (20.3935, 0.05);
/// Published offset, here a force on the carriage, and its tolerance.
const LOAD_N: (f64, f64) = (3.1648, 0.20);
/// Published viscous friction is 166.7 N s/m in one direction and 240.4 N s/m in the other. Here: half the
/// difference over the mean, and its tolerance.
const ASYMMETRY: (f64, f64) = (0.181, 0.20);
/// Missing force of the inverse model on the file with pulses: lower limit with mass and viscous friction
/// alone, and upper limit with the causes.
const MISSING_N: (f64, f64) = (8.0, 3.4);

#[test]
fn reference_the_real_drive_has_dry_friction_and_a_load() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/emps");
    if !folder.is_dir() {
        // `eprintln!` would not be shown, because a passing test captures its output.
        let _ = writeln!(std::io::stderr(), "skipped: {} is not there", folder.display());
        return;
    }
    let answer = diagnose(&Dataset::load(&folder).unwrap(), &|_| {}).unwrap();
    assert_eq!(answer.places[0].place, "guide");
    let accepted: Vec<_> = answer.effects.iter().filter(|effect| effect.accepted).collect();
    let value = |kind: Kind, key: &str| {
        accepted.iter().find(|effect| effect.kind == kind).map(|effect| effect.parameters[key].value)
    };
    let level = value(Kind::CoulombFriction, "level").expect("the friction is found");
    assert!((level / LEVEL_N.0 - 1.0).abs() < LEVEL_N.1, "{level}");
    // A load and directional viscous friction are nearly equivalent on strokes of one speed. The diagnosis
    // finds one of them, or both, and no other cause.
    let load = value(Kind::ConstantLoad, "force");
    let asymmetry = value(Kind::DirectionalDamping, "asymmetry");
    assert!(load.is_some() || asymmetry.is_some(), "{:?}", answer.attempts);
    assert!(load.is_none_or(|load| (load / LOAD_N.0 - 1.0).abs() < LOAD_N.1), "{load:?}");
    assert!(
        asymmetry.is_none_or(|found| (found.abs() / ASYMMETRY.0 - 1.0).abs() < ASYMMETRY.1),
        "{asymmetry:?}"
    );
    let found = 1 + usize::from(load.is_some()) + usize::from(asymmetry.is_some());
    assert_eq!(accepted.len(), found, "{:?}", answer.effects);
    // All three effects are published, so two of them alone do not explain the gap.
    assert!(found == 3 || answer.verdict != Verdict::Explained, "{:?}", answer.effects);
    let [refit, after] = answer.missing_force_n;
    assert!(refit > MISSING_N.0 && after < MISSING_N.1, "{:?}", answer.missing_force_n);
    // The lead of the screw: no effect of the library describes it.
    assert!(
        answer.left.iter().any(|left| left.contains("periodic in position, pitch 2.50 mm")),
        "{:?}",
        answer.left
    );
}
