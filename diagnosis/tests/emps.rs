//! A real drive: the electro-mechanical positioning system of Janot, Gautier and Brunot (2019), with
//! independently published figures.

use std::io::Write as _;
use std::path::Path;

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::diagnose;
use feeler_plant::effects::Kind;

/// Published Coulomb level and how far it may be off.
const LEVEL_N: (f64, f64) = (20.3935, 0.05);
/// Published offset, here a force on the carriage, and how far it may be off.
const LOAD_N: (f64, f64) = (3.1648, 0.20);
/// Missing force of the inverse model on the file with pulses: with mass and viscous guide alone, and what it
/// must come down to.
const MISSING_N: (f64, f64) = (8.0, 3.4);

#[test]
fn reference_the_real_drive_has_dry_friction_and_a_load() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/emps");
    if !folder.is_dir() {
        // Not by the macro for errors, whose words a passing test keeps to itself.
        let _ = writeln!(std::io::stderr(), "skipped: {} is not there", folder.display());
        return;
    }
    let answer = diagnose(&Dataset::load(&folder).unwrap(), &|_| {}).unwrap();
    assert_eq!(answer.places[0].place, "guide");
    let first = &answer.effects[0];
    assert_eq!(first.kind, Kind::CoulombFriction);
    assert!((first.parameters["level"].value / LEVEL_N.0 - 1.0).abs() < LEVEL_N.1, "{:?}", first.parameters);
    let load = answer
        .effects
        .iter()
        .find(|effect| effect.accepted && effect.kind == Kind::ConstantLoad)
        .expect("the load is found");
    assert!((load.parameters["force"].value / LOAD_N.0 - 1.0).abs() < LOAD_N.1, "{:?}", load.parameters);
    assert!(
        answer.look_alikes.iter().flatten().any(|kind| *kind == Kind::AsymmetricFriction),
        "{:?}",
        answer.look_alikes
    );
    let [refit, after] = answer.missing_force_n;
    assert!(refit > MISSING_N.0 && after < MISSING_N.1, "{:?}", answer.missing_force_n);
    // The screw's lead, and a viscous friction that is published as 166.7 and 240.4 N s/m; neither is in the
    // library.
    assert!(
        answer.left.iter().any(|left| left.contains("periodic in position, pitch 2.50 mm")),
        "{:?}",
        answer.left
    );
    assert!(
        answer
            .left
            .iter()
            .any(|left| left.contains("viscous friction") && left.contains("larger in one direction")),
        "{:?}",
        answer.left
    );
}
