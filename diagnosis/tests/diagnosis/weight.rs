//! Friction that grows with the weight that a joint holds, beside friction that does not.

use std::f64::consts::{FRAC_PI_2, TAU};

use feeler_diagnosis::report::Verdict;
use feeler_diagnosis::{Diagnosis, diagnose};
use feeler_plant::effects::Kind;

use crate::recovery::{SPACING_S, recorded};

/// An arm; its phase says how it stands at zero.
const ARM: &str = r#"
name = "arm"
axis = "rotational"
[bodies.arm]
mass = 0.5
gravity = 8.0
gravity_phase = PHASE
[springs.guide]
between = ["ground", "arm"]
damping = 0.6
[actuators.drive]
on = "arm"
reacts_on = "ground"
kind = "force"
limit = 40.0
[sensors.encoder]
reads = "arm.position"
noise = 1.0e-5
"#;
const ENCODER_NOISE_RAD: f64 = 1e-5;
const ROWS: usize = 4000;
/// The friction is a tenth of what moves the arm, whose inertia and gravity are believed within 10 %.
const RECOVERY: f64 = 0.12;

/// The answer for an arm with a hidden effect. Slow sines, which differ from record to record, swing the arm.
/// At zero the arm stands at `phase`, where the command `offset` holds it.
fn answered(effect: &str, torque: f64, [phase, offset]: [f64; 2]) -> Diagnosis {
    let arm = ARM.replace("PHASE", &phase.to_string());
    let command = |turn: f64| -> Vec<f64> {
        let at = |k: usize| {
            let t = k as f64 * SPACING_S;
            offset + torque * ((TAU * (0.4 + 0.1 * turn) * t).sin() + 0.4 * (TAU * 1.3 * t + turn).sin())
        };
        (0..ROWS).map(at).collect()
    };
    let commands = [0.0, 0.7, 1.3, 2.1].map(|turn| (command(turn), turn > 1.0));
    let real = format!("{arm}[springs.guide.effects.{effect}\n");
    diagnose(&recorded([&arm, &real], &commands, &[ENCODER_NOISE_RAD]), &|_| {}).expect("there is an answer")
}

fn kinds(answer: &Diagnosis) -> Vec<String> {
    answer.effects.iter().filter(|effect| effect.accepted).map(|effect| effect.kind.to_string()).collect()
}

/// Over a wide swing the level that follows the weight differs from a constant one.
#[test]
fn truth_friction_of_a_weight_and_constant_friction_are_told_apart_over_a_wide_swing() {
    for (kind, effect, size) in [
        ("load-friction", "load-friction]\nratio = 0.2", 0.2),
        ("coulomb-friction", "coulomb-friction]\nlevel = 1.0", 1.0),
    ] {
        let answer = answered(effect, 7.0, [0.0; 2]);
        assert_eq!(kinds(&answer), [kind], "{:?}", answer.adequacy.shortfalls);
        let is_alike = |pair: &[Kind; 2]| pair.contains(&Kind::LoadFriction);
        assert!(!answer.look_alikes.iter().any(is_alike), "{:?}", answer.look_alikes);
        let found = answer.effects[0].parameters[0].value;
        assert!((found / size - 1.0).abs() < RECOVERY, "{found}");
    }
}

/// Near the horizontal the weight hardly changes: which of the two acts, the records do not say.
#[test]
fn truth_over_a_narrow_swing_both_are_declared_alike() {
    let answer = answered("load-friction]\nratio = 0.2", 2.2, [FRAC_PI_2, 8.0]);
    let mut named: Vec<String> = kinds(&answer);
    named.extend(answer.look_alikes.iter().flatten().map(ToString::to_string));
    for kind in ["load-friction", "coulomb-friction"] {
        assert!(named.iter().any(|name| name == kind), "{named:?} {:?}", answer.adequacy.shortfalls);
    }
    assert_ne!(answer.verdict, Verdict::Explained);
}
