//! Effects of a slow machine with a coarse encoder and a noisy command are recovered.

use std::time::Duration;

use feeler_diagnosis::dataset::Record;
use feeler_diagnosis::report::Verdict;
use feeler_diagnosis::{Budget, Diagnosis, diagnose, diagnose_within};
use feeler_plant::effects::Kind;

use crate::adequacy::{BELIEVED, Motion, USUAL, accepted, answer, moved, told};

/// Relative tolerance of a value: the believed mass and damping are off by 5 and 20 %.
const RECOVERY: f64 = 0.15;

/// The answer to records of a machine's runs.
fn answered(text: &str, motion: &Motion, force: &dyn Fn(f64, f64) -> f64) -> Diagnosis {
    diagnose(&moved(text, motion, force), &|_| {}).expect("there is an answer")
}

/// A value of an accepted cause of this kind.
fn value(answer: &Diagnosis, kind: &str, parameter: &str) -> f64 {
    let found = answer.effects.iter().find(|effect| effect.accepted && effect.kind.name() == kind);
    found.unwrap_or_else(|| panic!("no {kind}: {}", told(answer))).parameters[parameter].value
}

fn assert_recovers(answer: &Diagnosis, kind: &str, parameter: &str, hidden: f64) {
    let found = accepted(answer);
    assert_eq!(found.first(), Some(&kind), "{}", told(answer));
    // A further cause is wrong, and may not be sure.
    assert!(found.len() == 1 || answer.verdict != Verdict::Explained, "{}", told(answer));
    let found = value(answer, kind, parameter);
    assert!((found / hidden - 1.0).abs() < RECOVERY, "{parameter} {found} for {hidden}: {}", told(answer));
}

/// The command without friction is about 6 N.
#[test]
fn truth_friction_of_four_fifths_of_the_command_is_recovered() {
    let motion = Motion { friction: 25.0, ..USUAL };
    let answer = answered(BELIEVED, &motion, &|_, _| 0.0);
    assert_recovers(&answer, "coulomb-friction", "level", 25.0);
}

/// Friction of a twentieth of the command, and of 95 %.
#[test]
fn truth_hardly_any_friction_and_almost_only_friction_are_recovered() {
    for friction in [0.3, 114.0] {
        let answer = answered(BELIEVED, &Motion { friction, ..USUAL }, &|_, _| 0.0);
        assert_recovers(&answer, "coulomb-friction", "level", friction);
    }
}

#[test]
fn truth_drag_is_told_from_friction_and_damping() {
    assert_recovers(&answer(&|_, v| 90.0 * v * v.abs()), "quadratic-drag", "drag", 90.0);
}

#[test]
fn truth_damping_that_differs_by_direction_is_recovered() {
    let force = |_: f64, v: f64| 12.0 * 0.4 * v.abs();
    assert_recovers(&answer(&force), "directional-damping", "asymmetry", 0.4);
}

/// The controller drives the carriage against a stop that nobody believed.
#[test]
fn truth_a_stop_that_nobody_believed_is_recovered() {
    let stop = |x: f64, v: f64| if x > 0.07 { 4e3 * (x - 0.07) + 30.0 * v } else { 0.0 };
    assert_recovers(&answer(&stop), "hard-stop", "position", 0.07);
}

/// The arm swings by a radian and more.
#[test]
fn truth_the_weight_of_an_arm_is_recovered() {
    let arm = BELIEVED.replace("name = \"slow\"", "axis = \"rotational\"");
    let motion = Motion { size: 10.0, command_noise: 0.5, ..USUAL };
    let answer = answered(&arm, &motion, &|x, _| 20.0 * (x + 0.6).sin());
    assert_recovers(&answer, "gravity", "amplitude", 20.0);
}

/// Friction at rest is 1.6 times that of fast motion, and fades over 20 mm/s.
#[test]
fn truth_friction_that_falls_with_speed_is_named_or_declared_alike() {
    let motion = Motion { friction: 10.0, ..USUAL };
    let answer = answered(BELIEVED, &motion, &|_, v| 6.0 * (-(v / 0.02).powi(2)).exp() * (v / 1e-3).tanh());
    let found = accepted(&answer);
    let is_named = found.contains(&"stribeck-friction");
    let is_alike = answer.look_alikes.iter().any(|alike| alike.contains(&Kind::StribeckFriction));
    let is_sure = answer.verdict == Verdict::Explained;
    assert!(is_named && (found.len() == 1 || !is_sure) || is_alike && !is_sure, "{}", told(&answer));
}

/// Friction is 13 N in one direction and 7 N in the other: the same as 10 N beside a load of 3 N.
#[test]
fn truth_friction_that_differs_by_direction_is_declared_alike_to_friction_beside_a_load() {
    let motion = Motion { friction: 10.0, ..USUAL };
    let answer = answered(BELIEVED, &motion, &|_, _| 3.0);
    let found = accepted(&answer);
    assert!(found == ["asymmetric-friction"] || found.len() == 2, "{}", told(&answer));
    assert_ne!(answer.verdict, Verdict::Explained, "{}", told(&answer));
    let is_alike = answer.look_alikes.iter().any(|alike| alike.contains(&Kind::AsymmetricFriction));
    assert!(is_alike, "{}", told(&answer));
}

/// Each horizon is scored on the check records that are long enough for it.
#[test]
fn truth_a_short_check_record_hides_no_longer_horizon() {
    for (short, expected) in
        [(vec![1], vec![Some(0.05), Some(0.25), Some(1.0), None]), (vec![1, 3], vec![Some(0.05), None])]
    {
        let mut dataset = moved(BELIEVED, &USUAL, &|_, _| 0.0);
        for r in short {
            let Record { name, spacing_s, commands, series, is_check, .. } = &dataset.records[r];
            let cut = |series: &Vec<f64>| series[..80].to_vec();
            let (commands, series) = (commands.iter().map(cut).collect(), series.iter().map(cut).collect());
            let cut =
                Record { is_check: *is_check, ..Record::even(name.clone(), *spacing_s, commands, series) };
            dataset.records[r] = cut;
        }
        let answer = diagnose_within(&dataset, Budget::of(Duration::ZERO), &|_| {}).expect("an answer");
        let seconds: Vec<_> = answer.adequacy.horizons.iter().map(|horizon| horizon.seconds).collect();
        assert_eq!(seconds, expected, "{}", told(&answer));
    }
}
