//! Balances of given motions under known forces.

use std::cell::Cell;
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
    let drives = vec![Driven { drive: 0, column: "u".into(), hold_s, noise: None }];
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

/// Bristles that slide over 2 mm, with a damping of 20 ms over their stiffness. Their force leads that of the
/// distance moved, so the drive appears to lag by a part of it. Six rows are a delay.
#[test]
fn truth_damping_of_bristles_is_no_lag() {
    const WAY_M: f64 = 2e-3;
    const AHEAD_S: f64 = 0.02;
    let machine = format!("{BELIEVED}[springs.guide.effects.coulomb-friction]\nlevel = 5.0\n");
    for (rows, is_late) in [(0.0, false), (6.0, true)] {
        // Position and direction at the last row.
        let last = Cell::new((f64::INFINITY, 0.0, 0.0));
        let (inverse, all) = records_of(&machine, (0.001, None), &|t, shift| {
            let at = t + rows * SPACING_S;
            let [x, v, a] = [0, 1, 2].map(|order| waves(at, order, shift));
            let (before, from, direction) = last.get();
            let moved = if at > before { x - from } else { 0.0 };
            let direction = moved.signum() + (direction - moved.signum()) * (-moved.abs() / WAY_M).exp();
            last.set((at, x, direction));
            let rate = (v - v.abs() * direction) / WAY_M;
            [waves(t, 0, shift), 1.2 * a + 4.0 * v + 6.0 * (direction + AHEAD_S * rate)]
        });
        for kind in [Kind::CommandDelay, Kind::ActuatorLag] {
            let cause = *all.iter().find(|one| one.definition.kind == kind).unwrap();
            let found = inverse.weigh(&[cause]).unwrap();
            assert_eq!(found.nats > 6.0, is_late, "{kind} of {rows} rows: {}", found.nats);
        }
        // Both are found by steps of 2 %, from rows in which the guide slides up to 3 mm.
        let turn = if is_late { continue } else { inverse.reversals.reversal };
        assert!((turn.length_m / WAY_M - 1.0).abs() < 0.1, "{turn:?}");
        assert!((turn.lead_s / AHEAD_S - 1.0).abs() < 0.2, "{turn:?}");
    }
}

/// Friction with a load is friction that depends on direction: the same forces with as many values.
#[test]
fn truth_equal_forces_balance_equally() {
    let (inverse, all) = inverse("", &|_, v| 6.0 * v.signum() + 2.0);
    let nats = |kinds: &[Kind]| {
        let set: Vec<Candidate> =
            kinds.iter().map(|kind| *all.iter().find(|one| one.definition.kind == *kind).unwrap()).collect();
        inverse.weigh(&set).unwrap().nats
    };
    let both = nats(&[Kind::CoulombFriction, Kind::ConstantLoad]);
    // The ridge is 1e-9 of a square, and thousands of rows count half a nat for each e-fold.
    assert!((both - nats(&[Kind::AsymmetricFriction])).abs() < 1e-3);
    assert!(both > nats(&[Kind::CoulombFriction]) + 100.0);
}

/// A record at constant acceleration reverses between two rows. Dahl's friction follows the distance moved;
/// its damping adds two levels times the lead over the reversal.
#[test]
fn truth_friction_reverses_over_its_length() {
    const ACCELERATION: f64 = 2.0;
    let turns_s = 20.0 + 0.37 * SPACING_S;
    let position: Vec<f64> =
        (0..8000).map(|k| 0.5 * ACCELERATION * (SPACING_S * f64::from(k) - turns_s).powi(2)).collect();
    let command = vec![0.0; position.len()];
    let measured = Measured {
        start_s: 0.0,
        spacing_s: SPACING_S,
        command: &command,
        position: &position,
        is_held: false,
    };
    let rows = Rows::new(&measured, 1.0);
    let times = rows.times_s();
    let inside = |t: f64| (t - turns_s).abs() < 5.0;
    for length_m in [1e-6, 1e-3] {
        let of = |lead_s: f64| {
            let turning = rows.turning(Reversal { length_m, lead_s, sharpness: 0 });
            rows.moving(&turning).directions().to_vec()
        };
        let (dry, damped) = (of(0.0), of(0.01));
        for (t, found) in times.iter().zip(&dry).filter(|(t, _)| inside(**t)) {
            let moved = 0.5 * ACCELERATION * (t - turns_s).powi(2);
            let exact = if *t < turns_s { -1.0 } else { 1.0 - 2.0 * (-moved / length_m).exp() };
            // The speed is linear between rows, so distances are exact but for the ends of the filter.
            assert!((found - exact).abs() < 1e-3, "{length_m} {t} {found} {exact}");
        }
        let spacing_s = times[1] - times[0];
        let rows = times.iter().zip(dry.iter().zip(&damped)).filter(|(t, _)| inside(**t));
        let area: f64 = rows.map(|(_, (dry, damped))| (damped - dry) * spacing_s).sum();
        assert!((area / (2.0 * 0.01) - 1.0).abs() < 1e-3, "{length_m} {area}");
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

/// The smooth force of a family in addition to some causes.
fn of_family(inverse: &Inverse, causes: &[Candidate], is_asked: fn(Family) -> bool) -> Smooth {
    inverse.beyond(causes).into_iter().find(|smooth| is_asked(smooth.family)).expect("it balances")
}

/// The drive makes the commanded force times 1 - 0.7 s/m |v|, half of it at the largest speed of 0.74 m/s.
/// Dry friction takes half of the command.
fn faded() -> (Inverse, Vec<Candidate>) {
    let friction = "[springs.guide.effects.coulomb-friction]\nlevel = 3.0\n";
    records_of(&format!("{BELIEVED}{friction}"), (0.02, None), &|t, shift| {
        let [x, v, a] = [0, 1, 2].map(|order| waves(t, order, shift));
        [x, (1.2 * a + 4.0 * v + 3.0 * v.signum()) / (1.0 - 0.7 * v.abs())]
    })
}

#[test]
fn truth_a_drive_that_falls_with_speed_is_seen_in_the_drive_and_replaces_drag() {
    let (inverse, all) = faded();
    let all_nats = inverse.beyond(&[]);
    let best = all_nats.iter().max_by(|a, b| a.evidence().total_cmp(&b.evidence())).unwrap();
    let Family::Fading { per_speed } = best.family else { panic!("{best:?}") };
    // The trial values are 0.027 s/m apart. Mass and damping, which are free, shift the best one slightly.
    assert!((per_speed - 0.7).abs() < 0.05, "{best:?}");
    assert!(best.family.place() == Place::Drive && best.share > 0.9 && best.nats > 50.0, "{best:?}");
    for kind in [Kind::QuadraticDrag, Kind::ViscousFriction] {
        let cause = *all.iter().find(|one| one.definition.kind == kind).unwrap();
        let instead = inverse.instead(&[cause]);
        let best = instead.iter().max_by(|a, b| a.gain.total_cmp(&b.gain)).unwrap();
        assert!(best.gain > 6.0 && best.smooth.family.place() == Place::Drive, "{kind}: {best:?}");
    }
}

/// Pitches over the whole range, from five to fourteen waves per stroke of 0.6 m.
#[test]
fn truth_friction_that_waves_is_seen_with_its_pitch() {
    for pitch in [0.11, 0.07, 0.043] {
        let best = beyond_friction(&|x, v| 6.0 * v.signum() * (1.0 + 0.5 * (TAU * x / pitch).sin()));
        let Family::Waves { pitch_m } = best.family else { panic!("{best:?}") };
        // Trial pitches are 0.4 waves per stroke apart.
        assert!((0.6 / pitch_m - 0.6 / pitch).abs() < 0.4, "{pitch} {best:?}");
        assert!(best.share > 0.5 && best.nats > 50.0, "{best:?}");
    }
}

type Law = dyn Fn(f64, f64) -> f64;

/// A right cause balances better than every smooth force instead of it.
#[test]
fn truth_no_smooth_force_replaces_a_cause_of_the_library() {
    let forces: [(Kind, &Law); 7] = [
        (Kind::CoulombFriction, &|_, v| 6.0 * v.signum()),
        (Kind::ViscousFriction, &|_, v| 20.0 * v),
        (Kind::QuadraticDrag, &|_, v| 40.0 * v * v.abs()),
        (Kind::StribeckFriction, &|_, v| v.signum() * (4.0 + 3.0 * (-(v / 0.1).powi(2)).exp())),
        (Kind::ConstantLoad, &|_, _| 2.0),
        (Kind::ForceRipple, &|x, _| 2.0 * (TAU * x / 0.08).sin()),
        (Kind::HardStop, &|x, _| 60.0 * (x - 0.2).max(0.0)),
    ];
    for (kind, force) in forces {
        let (inverse, all) = inverse("", force);
        let cause = *all.iter().find(|one| one.definition.kind == kind).unwrap();
        let gains = inverse.instead(&[cause]).into_iter().map(|instead| instead.gain);
        let most = gains.fold(f64::NEG_INFINITY, f64::max);
        assert!(most < -2.0, "{kind}: {most}");
    }
}

#[test]
fn truth_the_noise_of_a_command_is_no_smooth_force() {
    for hold_s in [Some(SPACING_S), None] {
        let (inverse, _) = records_of(BELIEVED, (0.1, hold_s), &|t, shift| {
            let late = hold_s.unwrap_or_default() / 2.0;
            let [v, a] = [1, 2].map(|order| waves(t + late, order, shift));
            [waves(t, 0, shift), 1.2 * a + 4.0 * v]
        });
        for smooth in inverse.beyond(&[]) {
            assert!(smooth.nats < 6.0, "{smooth:?}");
        }
    }
}

/// Two records at places 1.6 m apart: no row is near the places between them.
#[test]
fn regress_places_without_rows_do_not_hide_a_tight_spot() {
    let (inverse, all) = records_of(BELIEVED, (0.02, None), &|t, shift| {
        let [x, v, a] = [0, 1, 2].map(|order| waves(t, order, shift));
        let apart = if shift < 1.0 { 0.0 } else { 1.6 };
        let tight = 1.0 + (-((x - 0.05) / 0.15).powi(2)).exp();
        [x + apart, 1.2 * a + 4.0 * v + 6.0 * v.signum() * tight]
    });
    let places = of_family(&inverse, &friction(&all), |family| family == Family::Places);
    assert!(places.share.is_finite());
}

/// A family counts as many unknowns as it has terms, and one more for a shape.
#[test]
fn truth_a_family_counts_its_terms() {
    let (inverse, _) = inverse("", &|_, v| 6.0 * v.signum());
    let waves = Family::Waves { pitch_m: 0.1 };
    for (family, shapes) in [(Family::Motion, 0), (Family::Places, 0), (waves, 1), (Family::Time, 0)] {
        let terms = inverse.guide_terms(&inverse.moving_fitted(&inverse.reversals)[0], family).len();
        assert_eq!(terms + shapes, family.unknowns(), "{family:?}");
    }
}
