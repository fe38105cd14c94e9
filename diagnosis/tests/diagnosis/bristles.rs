//! Friction that bends before it slides is named where records resolve the bending, and only there.

use std::f64::consts::TAU;

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::diagnose;
use feeler_diagnosis::report::Verdict;
use feeler_plant::effects::Kind;

use crate::recovery::{SPACING_S, recorded};

const ROWS: usize = 2000;
/// Bristles of the machine below bend by 14 um.
const NOISE_M: f64 = 1e-8;

const BELIEVED: &str = r#"
name = "axis"
[bodies.carriage]
mass = 10.0
[springs.guide]
between = ["ground", "carriage"]
damping = 20.0
[actuators.drive]
on = "carriage"
reacts_on = "ground"
kind = "force"
[sensors.encoder]
reads = "carriage.position"
"#;

/// A force whose frequency rises evenly.
fn chirp(peak_n: f64, [from_hz, to_hz]: [f64; 2]) -> Vec<f64> {
    let lasts_s = ROWS as f64 * SPACING_S;
    let at = |t: f64| peak_n * (TAU * (from_hz * t + 0.5 * (to_hz - from_hz) / lasts_s * t * t)).sin();
    (0..ROWS).map(|k| at(k as f64 * SPACING_S)).collect()
}

/// Records of the axis with an effect at its guide: five below the friction of 7 N, two far above.
fn records_of(effect: &str) -> Dataset {
    records_with(effect, NOISE_M)
}

fn records_with(effect: &str, noise_m: f64) -> Dataset {
    let commands = [
        (chirp(3.0, [0.5, 5.0]), false),
        (chirp(12.0, [1.0, 3.0]), false),
        (chirp(2.5, [2.0, 10.0]), false),
        (chirp(3.4, [0.5, 3.0]), false),
        (chirp(3.6, [1.0, 8.0]), true),
        (chirp(3.2, [0.5, 6.0]), true),
        (chirp(20.0, [2.0, 4.0]), true),
    ];
    recorded([BELIEVED, &format!("{BELIEVED}{effect}")], &commands, &[noise_m])
}

#[test]
fn truth_bristles_are_named_where_records_resolve_them_and_dry_friction_is_not_called_bristles() {
    let bristles = r"
        [springs.guide.effects.lugre-friction]
        stiffness = 5.0e5
        damping = 3000.0
        coulomb = 4.0
        static = 7.0
        velocity = 5.0e-3
    ";
    let answer = diagnose(&records_of(bristles), &|_| {}).unwrap();
    let found = answer.effects.iter().find(|effect| effect.accepted).expect("an effect is named");
    assert_eq!(found.kind, Kind::LugreFriction);
    // Widths of the intervals for friction, which no law describes exactly.
    for (name, value) in [("stiffness", 5.0e5), ("damping", 3000.0), ("coulomb", 4.0), ("static", 7.0)] {
        let [low, high] = found.parameters[name].ci90;
        assert!(low < value && value < high, "{name}: {low} to {high}");
    }
    let stiff = "[springs.guide.effects.coulomb-friction]\nlevel = 4.0\n";
    let answer = diagnose(&records_of(stiff), &|_| {}).unwrap();
    let found: Vec<Kind> = answer.effects.iter().filter(|effect| effect.accepted).map(|e| e.kind).collect();
    assert_eq!(found, [Kind::CoulombFriction]);
}

/// Dry friction that yields is no other cause. The answer states how the guide yields, and so does the
/// repaired machine, whose own diagnosis then finds nothing.
#[test]
fn truth_how_dry_friction_yields_is_stated_with_the_answer() {
    let yielding = r"
        [springs.guide.effects.coulomb-friction]
        level = 6.0
        [springs.guide.effects.presliding]
        stiffness = 3.0e5
        damping_ratio = 0.3
    ";
    let dataset = records_of(yielding);
    let answer = diagnose(&dataset, &|_| {}).unwrap();
    let found: Vec<Kind> = answer.effects.iter().filter(|effect| effect.accepted).map(|e| e.kind).collect();
    assert_eq!(found, [Kind::CoulombFriction]);
    let [guide] = &answer.presliding[..] else { panic!("{:?}", answer.presliding) };
    assert_eq!(guide.on, "springs.guide");
    for (estimate, value, most) in [(&guide.stiffness, 3.0e5, 1.5), (&guide.damping_ratio, 0.3, 4.0)] {
        let [low, high] = estimate.ci90;
        assert!((low..high).contains(&value) && high < most * low, "{value}: {low} to {high}");
    }
    let effects = &answer.machine.springs["guide"].effects;
    let stated =
        effects.iter().find(|effect| effect.definition.kind == Kind::Presliding).expect("it is stated");
    assert!((stated.values[0] / guide.stiffness.value - 1.0).abs() < 1e-12);
    // Noise above the deflection of 20 um hides it.
    let coarse = diagnose(&records_with(yielding, 4e-5), &|_| {}).unwrap();
    assert!(coarse.presliding.is_empty(), "{:?}", coarse.presliding);
    let again = Dataset { machine: answer.machine.clone(), ..dataset };
    let answer = diagnose(&again, &|_| {}).unwrap();
    assert_eq!((answer.verdict, answer.presliding.len()), (Verdict::NoGap, 0));
}
