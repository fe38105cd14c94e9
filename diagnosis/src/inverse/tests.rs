//! Balances of given motions under known forces.

use std::f64::consts::{PI, TAU};

use feeler_files::Document;
use feeler_plant::assembly::Source;
use feeler_plant::effects::{Kind, Place};

use super::*;
use crate::chance::Chance;
use crate::dataset::Driven;
use crate::fit::candidates::candidates;

const BELIEVED: &str = r#"
name = "axis"
[bodies.carriage]
mass = 1.3
[springs.guide]
between = ["ground", "carriage"]
damping = 6.0
[actuators.drive]
on = "carriage"
reacts_on = "ground"
kind = "force"
[sensors.encoder]
reads = "carriage.position"
"#;
const OMEGA: f64 = 2.0;
const SPACING_S: f64 = 5e-3;

/// Position as a sum of two waves, or one of its derivatives.
fn waves(t: f64, order: i32, shift: f64) -> f64 {
    let wave = |size: f64, omega: f64, phase: f64| {
        size * omega.powi(order) * (omega * t + phase + f64::from(order) * 0.5 * PI).sin()
    };
    wave(0.2, OMEGA, shift) + wave(0.1, 1.7 * OMEGA, 2.0 * shift)
}

/// Three records of 1.2 kg with 4 N s/m under the force `law` of position and speed. The command has noise of
/// 2 % of its largest value, and the machine's guide has `effect`.
fn inverse(effect: &str, law: &dyn Fn(f64, f64) -> f64) -> (Inverse, Vec<Candidate>) {
    balance_of(&format!("{BELIEVED}{effect}"), 0.02, law)
}

/// Such records for a complete machine file, with this relative noise of the command.
fn balance_of(machine: &str, share: f64, law: &dyn Fn(f64, f64) -> f64) -> (Inverse, Vec<Candidate>) {
    records_of(machine, (share, None), &|t, shift| {
        let [x, v, a] = [0, 1, 2].map(|order| waves(t, order, shift));
        [x, 1.2 * a + 4.0 * v + law(x, v)]
    })
}

/// Three records of position and command over the time, each with its shift.
fn records_of(
    machine: &str,
    (share, hold_s): (f64, Option<f64>),
    series: &dyn Fn(f64, f64) -> [f64; 2],
) -> (Inverse, Vec<Candidate>) {
    let machine = Document::parse(machine, "axis.toml").unwrap().scenario.machine;
    let mut chance = Chance::seeded(5);
    let mut record = |i: usize, shift: f64| {
        let (x, clean): (Vec<f64>, Vec<f64>) =
            (0..8000).map(|k| series(SPACING_S * f64::from(k), shift)).map(|[x, u]| (x, u)).unzip();
        let noise = share * clean.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        let commands = vec![clean.iter().map(|u| u + noise * chance.deviate()).collect()];
        Record { is_check: i == 2, ..Record::even(format!("{i}.csv"), SPACING_S, commands, vec![x]) }
    };
    let channel = Channel { column: "x".into(), source: Source::Sensor(0), noise: 1e-6, resolution: 0.0 };
    let records = vec![record(0, 0.3), record(1, 1.1), record(2, 2.0)];
    let drives = vec![Driven { drive: 0, column: "u".into(), hold_s }];
    let dataset = Dataset::new("axis", machine, drives, vec![channel], records);
    (Inverse::new(&dataset).expect("an axis that moves as one"), candidates(&dataset.machine))
}

/// The pair of kinds, or the single kind, with the largest gain, with their values.
fn best(found: &(Inverse, Vec<Candidate>), count: usize) -> (Vec<Kind>, Vec<Vec<f64>>) {
    let (inverse, all) = found;
    let sets: Vec<Vec<Candidate>> = match count {
        1 => all.iter().map(|one| vec![*one]).collect(),
        _ => (0..all.len()).flat_map(|i| (0..i).map(move |j| vec![all[j], all[i]])).collect(),
    };
    let weighed = sets.iter().filter_map(|set| Some((set, inverse.weigh(set)?)));
    let (set, best) = weighed.max_by(|a, b| a.1.nats.total_cmp(&b.1.nats)).unwrap();
    (set.iter().map(|cause| cause.definition.kind).collect(), best.values)
}

/// A held command acts half a row late. Without a stated hold it may be that late. Two rows are a delay.
#[test]
fn truth_what_a_hold_makes_late_is_no_delay() {
    for hold_s in [Some(SPACING_S), None] {
        for (rows, is_late) in [(0.5, false), (2.0, true)] {
            let (inverse, all) = records_of(BELIEVED, (0.001, hold_s), &|t, shift| {
                let [v, a] = [1, 2].map(|order| waves(t + rows * SPACING_S, order, shift));
                [waves(t, 0, shift), 1.2 * a + 4.0 * v]
            });
            for kind in [Kind::CommandDelay, Kind::ActuatorLag] {
                let cause = *all.iter().find(|one| one.definition.kind == kind).unwrap();
                let nats = inverse.weigh(&[cause]).unwrap().nats;
                assert_eq!(nats > 6.0, is_late, "{kind} of {rows} rows, held {hold_s:?}: {nats}");
            }
        }
    }
}

fn friction(all: &[Candidate]) -> Vec<Candidate> {
    all.iter().filter(|one| one.definition.kind == Kind::CoulombFriction).copied().collect()
}

/// A level loses some percent near reversals, where the smooth direction changes. A noise of 2 % over
/// thousands of rows shifts the result by less than a percent.
const OFF: f64 = 0.05;

#[test]
fn truth_forces_of_the_motion_are_found_with_their_values() {
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < OFF, "{a} {b}");
    let (kinds, values) = best(&inverse("", &|_, v| 6.0 * v.signum()), 1);
    assert_eq!(kinds, [Kind::CoulombFriction]);
    close(values[0][0], 6.0);
    let (kinds, values) = best(&inverse("", &|x, _| -2.0 * (TAU * x / 0.08 + 0.4).sin()), 1);
    assert_eq!(kinds, [Kind::ForceRipple]);
    close(values[0][0], 2.0);
    close(values[0][2], 0.4);
    let (kinds, values) = best(&inverse("", &|x, v| 6.0 * v.signum() - 2.0 * (TAU * x / 0.08).sin()), 2);
    assert_eq!(kinds, [Kind::ForceRipple, Kind::CoulombFriction]);
    close(values[1][0], 6.0);
}

#[test]
fn truth_stated_gravity_is_part_of_a_balance_with_and_without_noise() {
    let turning = BELIEVED.replace("[bodies", "axis = \"rotational\"\n[bodies");
    let turning = turning.replace("mass = 1.3", "mass = 1.3\ngravity = 8.0\ngravity_phase = 0.5");
    for share in [0.0, 0.02] {
        let found = balance_of(&turning, share, &|x, v| 8.4 * (x + 0.5).sin() + 6.0 * v.signum());
        let (kinds, values) = best(&found, 1);
        assert_eq!(kinds, [Kind::CoulombFriction]);
        assert!((values[0][0] / 6.0 - 1.0).abs() < OFF, "{values:?}");
        assert!(found.0.weight > 0.0 && found.0.is_noisy == (share > 0.0));
        let gravity = found.0.weigh(&friction(&found.1)).unwrap().believed;
        let gravity = gravity.iter().find(|(part, _)| *part == Part::Gravity).unwrap().1;
        // A motion of 0.3 rad separates gravity from mass and load: sine and cosine differ by a few percent
        // there.
        assert!((gravity / 1.05 - 1.0).abs() < OFF, "{gravity}");
    }
}

#[test]
fn truth_believed_friction_within_its_tolerance_needs_no_cause() {
    let believed = "[springs.guide.effects.coulomb-friction]\nlevel = 10.0\n";
    let (inverse, all) = inverse(believed, &|_, v| 6.0 * v.signum());
    let gain = |one: &Candidate| Some((inverse.weigh(&[*one])?.nats, one.definition.kind));
    let most = all.iter().filter_map(gain).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    // The only remaining error is that of the smooth direction near reversals.
    assert!(most.0 < 15.0, "{most:?}");
}

#[test]
fn truth_damping_by_direction_and_a_stop_are_found_with_their_values() {
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < OFF, "{a} {b}");
    let (kinds, values) = best(&inverse("", &|_, v| 40.0 * v.max(0.0) + 10.0 * v.min(0.0)), 1);
    assert_eq!(kinds, [Kind::DirectionalDamping]);
    // The believed damping is fitted, too, and shares its symmetric part with the cause.
    let [damping, asymmetry] = values[0][..] else { panic!("{values:?}") };
    close(damping * asymmetry, 15.0);
    for side in [-1.0, 1.0] {
        let stop = |x: f64, _| side * 60.0 * (side * x - 0.2).max(0.0);
        let (kinds, values) = best(&inverse("", &stop), 1);
        assert_eq!(kinds, [Kind::HardStop]);
        // Trial positions are 13 mm apart, and stiffness makes up for the difference.
        assert!((side * values[0][0] - 0.2).abs() < 0.013, "{values:?}");
        assert!((values[0][1] / 60.0 - 1.0).abs() < 0.2, "{values:?}");
    }
}

/// The smooth force with the largest gain in addition to dry friction.
fn beyond_friction(force: &dyn Fn(f64, f64) -> f64) -> Smooth {
    let (inverse, all) = inverse("", force);
    let found = inverse.beyond(&friction(&all));
    found.into_iter().max_by(|a, b| a.nats.total_cmp(&b.nats)).unwrap()
}

#[test]
fn truth_a_force_that_no_effect_makes_is_seen_at_its_place() {
    let forces: [&dyn Fn(f64, f64) -> f64; 2] = [
        &|x, v| 6.0 * v.signum() * (1.0 + 8.0 * x * x),
        // A tight spot that is narrow against the stroke.
        &|x, v| 6.0 * v.signum() * (1.0 + (-((x - 0.05) / 0.04).powi(2)).exp()),
    ];
    for force in forces {
        let smooth = beyond_friction(force);
        assert!(
            smooth.family.place() == Place::Guide && smooth.share > 0.5 && smooth.nats > 50.0,
            "{smooth:?}"
        );
    }
}

/// Most of the command is friction, so that it stays near one level, with noise of a tenth of it.
#[test]
fn truth_a_limit_gains_nothing_by_clipping_the_noise_of_a_command() {
    let friction = "[springs.guide.effects.coulomb-friction]\nlevel = 20.0\n";
    let (inverse, all) = balance_of(&format!("{BELIEVED}{friction}"), 0.1, &|_, v| 20.0 * v.signum());
    let limit = all.iter().find(|one| one.definition.kind == Kind::ForceLimit).copied().unwrap();
    let gain = inverse.weigh(&[limit]).unwrap().nats;
    // Less than a first cause needs.
    assert!(gain < 6.0, "{gain}");
}
