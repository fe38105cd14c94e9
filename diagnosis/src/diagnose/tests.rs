//! Composes answers from records of known machines.

use feeler_files::Document;
use feeler_plant::assembly::{Source, assemble};
use feeler_plant::effects::Kind;

use super::*;
use crate::chance::Chance;
use crate::dataset::{Channel, Driven, Record};
use crate::fit::odds::room_above_noise;
use crate::predict::Predictor;
use crate::report::Verdict;

const BELIEVED: &str = "[bodies.axis]\nmass = 2.0\n[springs.guide]\nbetween = [\"ground\", \"axis\"]\n\
    damping = 10.0\n[sensors.encoder]\nreads = \"axis.position\"\nnoise = 1e-6\n\
    [actuators.drive]\non = \"axis\"\nkind = \"force\"\n";
const LOAD: &str = "[springs.guide.effects.constant-load]\nforce = 3.0\n";

/// Four records of the axis with a load.
fn loaded() -> Dataset {
    of_real(BELIEVED, &format!("{BELIEVED}{LOAD}"), 8.0)
}

/// Four records of a real axis, with commands of an amplitude in N.
fn of_real(believed: &str, real: &str, amplitude_n: f64) -> Dataset {
    let machine = |text: &str| Document::parse(text, "axis.toml").unwrap().scenario.machine;
    let channel = Channel { column: "x".into(), source: Source::Sensor(0), noise: 1e-6, resolution: 0.0 };
    let drives = vec![Driven { drive: 0, column: "u".into(), hold_s: Some(2e-3), noise: None }];
    let record = |i: u8| {
        let at = |k: i32| amplitude_n * (f64::from(k) * (0.02 + 0.01 * f64::from(i))).sin();
        let command = (0..500).map(at).collect();
        let record = Record::even(format!("{i}.csv"), 2e-3, vec![command], vec![vec![0.0; 500]]);
        Record { is_check: i % 2 == 1, ..record }
    };
    let records = (0..4).map(record).collect();
    let mut dataset = Dataset::new("axis", machine(believed), drives, vec![channel], records);
    for r in 0..dataset.records.len() {
        let real = assemble(&machine(real)).unwrap();
        let seen = Predictor::new(real, &dataset, &dataset.records[r]).unwrap().free().unwrap();
        dataset.records[r].series = seen.series;
    }
    dataset
}

/// An encoder has steps of 2.5 times its noise. Its readings scatter more than the noise, but a machine
/// that lacks nothing has no room for a cause.
#[test]
fn truth_steps_of_readings_leave_no_room_for_a_cause() {
    let rooms_of = |real: &str| {
        // Over strokes of some micrometres noise is most of what a prediction misses.
        let mut dataset = of_real(BELIEVED, real, 2e-3);
        let (noise, resolution) = (0.4e-6, 1e-6);
        (dataset.channels[0].noise, dataset.channels[0].resolution) = (noise, resolution);
        let mut chance = Chance::default();
        for x in dataset.records.iter_mut().flat_map(|record| record.series.iter_mut().flatten()) {
            *x = ((*x + noise * chance.normal()) / resolution).round() * resolution;
        }
        let found = search(&dataset, Budget::unlimited(), &|_| {}, |_, _| false).unwrap();
        [room, room_above_noise].map(|room| room(&found.task, &found.calibrated)[1])
    };
    // 500 rows know a mean square to 6 %. That is a nat over the eight looks of each of four records.
    let [above_noise_itself, above_all_noise] = rooms_of(BELIEVED);
    assert!(above_noise_itself > 7.0 && above_all_noise < 4.0, "{above_noise_itself} {above_all_noise}");
    let [_, loaded] = rooms_of(&format!("{BELIEVED}{}", LOAD.replace("3.0", "2e-3")));
    assert!(loaded > 7.0, "{loaded}");
}

/// Damping is three times the believed one, which may be twice as large. A law that explains slightly
/// more comes second. A law that explains far more comes first.
#[test]
fn truth_of_equal_causes_that_of_a_value_at_its_limit_comes_first() {
    let mut dataset = loaded();
    let real = BELIEVED.replace("damping = 10.0", "damping = 30.0");
    let real = Document::parse(&real, "axis.toml").unwrap().scenario.machine;
    for r in 0..dataset.records.len() {
        let seen = Predictor::new(assemble(&real).unwrap(), &dataset, &dataset.records[r]).unwrap();
        dataset.records[r].series = { seen }.free().unwrap().series;
    }
    let found = search(&dataset, Budget::unlimited(), &|_| {}, |_, _| true).unwrap();
    let judge = Judge::new(&dataset, &found);
    let is_damping = |scored: &&Scored| scored.causes[0].definition.kind == Kind::ViscousFriction;
    let damping = found.singles.iter().find(is_damping).unwrap();
    let other = candidates(&dataset.machine)
        .into_iter()
        .find(|cause| cause.definition.kind == Kind::QuadraticDrag)
        .unwrap();
    for (times, freed_first) in [(0.98, true), (0.1, false)] {
        let mut drag = Scored { causes: vec![other], ..damping.clone() };
        drag.misfits.iter_mut().flatten().for_each(|misfit| *misfit = *misfit * times - 0.05 * (1.0 - times));
        let mut ranked = [&drag, damping];
        judge.prefer_freed(&mut ranked, &found.calibrated);
        assert_eq!(is_damping(&ranked[0]), freed_first, "{times}");
        // No value of the machine with that cause is at its limit.
        let mut ranked = [&drag, damping];
        judge.prefer_freed(&mut ranked, damping);
        assert!(!is_damping(&ranked[0]), "{times}");
    }
}

/// A load of 3 N beside believed friction of 4 N is friction of 7 N one way and of 1 N the other. The
/// answer names the load alone.
#[test]
fn truth_a_sum_with_believed_friction_is_its_other_part() {
    let believed = format!("{BELIEVED}[springs.guide.effects.coulomb-friction]\nlevel = 4.0\n");
    let real = format!("{BELIEVED}{LOAD}[springs.guide.effects.coulomb-friction]\nlevel = 4.0\n");
    let dataset = of_real(&believed, &real, 12.0);
    let found = search(&dataset, Budget::unlimited(), &|_| {}, |_, _| true).unwrap();
    let judge = Judge::new(&dataset, &found);
    let is_sum = |scored: &&Scored| scored.causes[0].definition.kind == Kind::AsymmetricFriction;
    let split = judge.split(found.singles.iter().find(is_sum).unwrap()).unwrap();
    let kinds: Vec<Kind> = split.causes.iter().map(|cause| cause.definition.kind).collect();
    assert_eq!(kinds, [Kind::ConstantLoad]);
    // A thousandth of the command.
    assert!((split.values(0)[0] - 3.0).abs() < 0.012, "{:?}", split.values(0));
}

/// Commands of 2 ms without a stated hold act 0.4 rows late. Their unknown timing takes a delay of that
/// size over, so the answer doubts the drive. Without a delay nothing is doubted.
#[test]
fn truth_calibration_with_a_doubtful_value_is_not_called_no_gap() {
    for (delay_s, verdict) in [(8e-4, Verdict::NotIdentifiable), (0.0, Verdict::NoGap)] {
        let delay = format!("[actuators.drive.effects.command-delay]\ndelay = {delay_s:e}\n");
        let mut dataset = of_real(BELIEVED, &format!("{BELIEVED}{delay}"), 8.0);
        // A sampled command goes in straight lines: half a row earlier than one that is held.
        for record in &mut dataset.records {
            let held = record.commands[0].clone();
            let between = |k: usize| 0.5 * (held[k] + held[k.saturating_sub(1)]);
            record.commands[0] = (0..held.len()).map(between).collect();
        }
        dataset.drives[0].hold_s = None;
        let answer = diagnose(&dataset, &|_| {}).unwrap();
        let told = (answer.verdict, &answer.adequacy.shortfalls);
        assert_eq!(answer.verdict, verdict, "{told:?}");
        let places: Vec<&str> = answer.places.iter().map(|place| place.place).collect();
        let doubted: &[&str] = if delay_s > 0.0 { &["drive"] } else { &[] };
        assert_eq!(places, doubted, "{told:?}");
        assert!(answer.effects.is_empty(), "{told:?}");
    }
}

/// While a drive pushes the way it moves, a dead band acts like dry friction. Believed friction may be
/// half as large, so it hides a dead band of a tenth of the command. Friction of less than that hides
/// none, nor does any where the drive brakes a heavy axis.
#[test]
fn truth_a_dead_band_that_friction_may_hide_leaves_the_answer_unsure() {
    let light = BELIEVED.replace("mass = 2.0", "mass = 0.02");
    let cases = [
        (light.as_str(), 3.0, 4e-4, Verdict::NotIdentifiable),
        (light.as_str(), 0.3, 4e-4, Verdict::NoGap),
        (BELIEVED, 3.0, 4e-5, Verdict::NoGap),
    ];
    for (axis, level, noise, verdict) in cases {
        let believed = format!("{axis}[springs.guide.effects.coulomb-friction]\nlevel = {level:.1}\n");
        let mut dataset = of_real(&believed, &believed, 8.0);
        dataset.channels[0].noise = noise;
        let mut chance = Chance::default();
        for x in dataset.records.iter_mut().flat_map(|record| record.series.iter_mut().flatten()) {
            *x += noise * chance.normal();
        }
        let answer = diagnose(&dataset, &|_| {}).unwrap();
        let told = (answer.verdict, &answer.adequacy.shortfalls);
        assert_eq!(answer.verdict, verdict, "{told:?}");
        assert!(answer.effects.is_empty(), "{told:?}");
        let is_told = answer.adequacy.shortfalls.iter().any(|short| short.what.contains("drive-deadband"));
        assert_eq!(is_told, verdict == Verdict::NotIdentifiable, "{told:?}");
    }
}

/// A cause with too little evidence to be accepted leaves a doubt at its place. One without evidence
/// leaves none.
#[test]
fn truth_a_cause_that_nearly_explains_more_leaves_the_answer_unsure() {
    let dataset = loaded();
    let found = search(&dataset, Budget::unlimited(), &|_| {}, |_, _| true).unwrap();
    let judge = Judge::new(&dataset, &found);
    let is_load = |scored: &&Scored| scored.causes[0].definition.kind == Kind::ConstantLoad;
    let single = found.singles.iter().find(is_load).unwrap();
    for (times, may_be_hidden) in [(1.0, false), (0.7, true), (1e-3, false)] {
        let mut tried = Scored { misfits: found.calibrated.misfits.clone(), ..single.clone() };
        tried.misfits.iter_mut().flatten().for_each(|misfit| *misfit *= times);
        // The balance of forces does not count here.
        tried.balanced = None;
        let [check, all] = [judge.check(&found.calibrated, &tried), judge.all(&tried)];
        assert_eq!(judge.is_acceptable(&tried), times < 0.5, "{check} {all}");
        let attempts = Attempts { fitted: vec![tried], ..Attempts::default() };
        let told: Vec<String> = judge.hidden(&attempts).into_iter().map(|doubt| doubt.what).collect();
        let nearly = "constant-load at the guide would explain more, but the evidence is too little to \
                      accept it (record more of the same)";
        let is_told = told.iter().any(|what| what == nearly);
        assert_eq!(is_told, may_be_hidden, "{check} {all} {told:?}");
    }
}

/// A single cause is dropped only if it may be absent and removes little of the error.
#[test]
fn truth_a_single_cause_is_dropped_if_it_may_be_absent_and_removes_less_than_half() {
    let dataset = loaded();
    let mut found = search(&dataset, Budget::unlimited(), &|_| {}, |_, _| true).unwrap();
    // Without time left the deviations of the fit are those of the answer.
    found.task.budget = Budget::of(std::time::Duration::ZERO);
    let is_load = |scored: &&Scored| scored.causes[0].definition.kind == Kind::ConstantLoad;
    let single = found.singles.iter().find(is_load).unwrap();
    let size = single.fitted.model.unknown_of(0, 0).unwrap();
    let least = Criteria::default().least_closed;
    for (share, removes_much) in [(1.0, true), (0.2, false)] {
        for (deviation, may_be_absent) in [(0.1, false), (1.0, true)] {
            let mut accepted = single.clone();
            let theta = &mut accepted.fitted.theta[size];
            *theta *= share;
            accepted.fitted.sigma[size] = deviation * theta.abs();
            let judge = Judge::new(&dataset, &found);
            assert_eq!(judge.closed(&accepted) >= least, removes_much, "{}", judge.closed(&accepted));
            assert_eq!(judge.most_likely_absent(&accepted).is_some(), may_be_absent);
            let attempts = Attempts::default();
            let budget = found.task.budget;
            let mut composing = Composing { judge, budget, accepted, rivals: Vec::new(), attempts };
            composing.drop_absent();
            let is_dropped = composing.accepted.causes.is_empty();
            assert_eq!(is_dropped, may_be_absent && !removes_much, "{share} {deviation}");
            assert_eq!(composing.attempts.fitted.len(), usize::from(is_dropped));
        }
    }
}
