//! Hidden effects are recovered: a machine with an effect is recorded, and diagnosed with the machine without
//! the effect.

use std::f64::consts::{PI, TAU};

use feeler_diagnosis::adequacy::{Condition, Shortfall};
use feeler_diagnosis::dataset::{Channel, Dataset, Driven, Record};
use feeler_diagnosis::predict::Predictor;
use feeler_diagnosis::report::{AttemptOutcome, Verdict};
use feeler_diagnosis::{Diagnosis, diagnose};
use feeler_files::Document;
use feeler_plant::assembly::{Source, assemble};
use feeler_plant::description::Engagement;
use feeler_plant::effects::Kind;

use crate::Noise;

pub(crate) const SPACING_S: f64 = 1e-3;
const ROWS: usize = 1200;
const ENCODER_NOISE_M: f64 = 2e-7;
const ACCELERATION_NOISE_M_PER_S2: f64 = 0.03;

const BELIEVED: &str = r#"
name = "bench"
[bodies.motor]
mass = 7.0
[bodies.tip]
mass = 5.0
[springs.guide]
between = ["ground", "motor"]
damping = 60.0
[springs.transmission]
between = ["motor", "tip"]
rigid = true
[actuators.drive]
on = "motor"
reacts_on = "ground"
kind = "force"
limit = 400.0
[sensors.encoder]
reads = "motor.position"
noise = 2.0e-7
[sensors.motor_accelerometer]
reads = "motor.acceleration"
noise = 0.03
[sensors.tip_accelerometer]
reads = "tip.acceleration"
noise = 0.03
"#;

/// One body on a guide; its only sensor is an encoder at the motor.
const BELIEVED_STIFF: &str = r#"
name = "axis"
[bodies.motor]
mass = 12.0
[springs.guide]
between = ["ground", "motor"]
damping = 50.0
[actuators.drive]
on = "motor"
reacts_on = "ground"
kind = "force"
limit = 400.0
[sensors.encoder]
reads = "motor.position"
noise = 2.0e-7
"#;

fn machine(text: &str) -> feeler_plant::description::Machine {
    Document::parse(text, "bench.toml").expect("the text is a machine").scenario.machine
}

pub(crate) fn multisine(peak_n: f64, low_hz: f64, high_hz: f64, turn: f64) -> Vec<f64> {
    const LINES: u32 = 16;
    let line = |i: u32| low_hz * (high_hz / low_hz).powf(f64::from(i) / f64::from(LINES - 1));
    let raw: Vec<f64> = (0..ROWS)
        .map(|k| {
            // Held over two rows, as by a controller.
            let t = (k / 2 * 2) as f64 * SPACING_S;
            (0..LINES)
                .map(|i| {
                    (TAU * line(i) * t - PI * f64::from(i * i) / f64::from(LINES) + turn * f64::from(i)).sin()
                })
                .sum()
        })
        .collect();
    let largest = raw.iter().fold(0.0_f64, |m: f64, x: &f64| m.max(x.abs()));
    raw.iter().map(|x| peak_n * x / largest).collect()
}

/// Six experiments at two levels with noise, on the bench with `effect`, as a dataset whose believed machine
/// lacks the effect.
fn records_of(effect: &str) -> Dataset {
    records_on(BELIEVED, effect)
}

fn records_on(text: &str, effect: &str) -> Dataset {
    records_between(text, &format!("{text}\n{effect}"))
}

/// Records of machine `real`, as a dataset with the machine `believed`.
fn records_between(believed: &str, real: &str) -> Dataset {
    let commands = [
        (multisine(90.0, 1.0, 150.0, 0.0), false),
        (multisine(80.0, 1.0, 150.0, 0.7), false),
        (multisine(25.0, 1.0, 60.0, 0.3), false),
        (multisine(30.0, 1.0, 60.0, 1.1), false),
        (multisine(60.0, 2.0, 150.0, 1.9), true),
        (multisine(35.0, 2.0, 150.0, 2.3), true),
    ];
    let noises = [ENCODER_NOISE_M, ACCELERATION_NOISE_M_PER_S2, ACCELERATION_NOISE_M_PER_S2];
    recorded([believed, real], &commands, &noises)
}

/// Records of machine `real` in free motion, one for each command, as a dataset with the machine `believed`.
/// Commands for check experiments are marked; each sensor has its noise.
pub(crate) fn recorded(
    [believed, real]: [&str; 2],
    commands: &[(Vec<f64>, bool)],
    noises: &[f64],
) -> Dataset {
    let believed = machine(believed);
    let channel = |(i, (name, &noise)): (usize, (&String, &f64))| Channel {
        column: name.clone(),
        source: Source::Sensor(i),
        noise,
        resolution: 0.0,
    };
    let channels: Vec<Channel> = believed.sensors.keys().zip(noises).enumerate().map(channel).collect();
    let record = |(i, (command, is_check)): (usize, &(Vec<f64>, bool))| {
        let series = vec![vec![0.0; command.len()]; channels.len()];
        let record = Record::even(format!("{i}.csv"), SPACING_S, vec![command.clone()], series);
        Record { engagement: Some(Engagement::Free), is_check: *is_check, ..record }
    };
    let records = commands.iter().enumerate().map(record).collect();
    let drives = vec![Driven { drive: 0, column: "command".into(), hold_s: Some(SPACING_S), noise: None }];
    let mut dataset = Dataset::new("bench", believed, drives, channels, records);
    let real = machine(real);
    let mut noise = Noise(7);
    for r in 0..dataset.records.len() {
        let assembly = assemble(&real).expect("it assembles");
        let mut seen = Predictor::new(assembly, &dataset, &dataset.records[r])
            .and_then(|mut real| real.free())
            .expect("it moves")
            .series;
        for (series, sigma) in seen.iter_mut().zip(noises) {
            for x in series.iter_mut() {
                *x += sigma * noise.draw();
            }
        }
        dataset.records[r].series = seen;
    }
    dataset
}

fn first(answer: &Diagnosis) -> (Kind, f64) {
    let effect = answer.effects.first().expect("an effect is named");
    (effect.kind, effect.parameters[0].value)
}

/// A hundred times the uncertainty due to noise for these levels, but small for an engineer.
const RECOVERY: f64 = 0.03;

/// A mass is believed within 10 %. Motion alone determines only the ratio of a gain to the mass that it
/// moves.
#[test]
fn truth_a_gain_is_known_no_better_than_the_mass_that_it_moves() {
    let lighter = BELIEVED_STIFF.replace("mass = 12.0", "mass = 11.4");
    let real = format!("{lighter}\n[actuators.drive.effects.drive-gain]\ngain = 1.3\n");
    let answer = diagnose(&records_between(BELIEVED_STIFF, &real), &|_| {}).unwrap();
    let gain = answer.effects.iter().find(|effect| effect.kind == Kind::DriveGain);
    let gain = &gain.expect("a gain is found").parameters[0];
    let [low, high] = gain.ci90;
    assert!(low < 1.3 && 1.3 < high, "{low} to {high}");
    // The tolerance is two standard deviations, so the 90 % interval reaches 8 % to either side. Damping is
    // believed within a factor of two and adds hardly anything.
    assert!((0.5 * (high - low) / gain.value / 0.08 - 1.0).abs() < 0.2, "{low} to {high}");
    // The records cannot correct the believed mass, and the gain is wrong by the same factor.
    assert!((gain.value * 11.4 / 12.0 / 1.3 - 1.0).abs() < RECOVERY, "{}", gain.value);
}

/// Noise estimated from the scatter of the readings includes their steps. The steps still contradict a file
/// that states finer ones, but not a file that states none.
#[test]
fn truth_readings_in_coarser_steps_than_the_file_states_are_a_finding() {
    let step_m = 4e-4;
    let mut dataset = records_on(BELIEVED_STIFF, "");
    for record in &mut dataset.records {
        record.series[0].iter_mut().for_each(|x| *x = (*x / step_m).round() * step_m);
    }
    dataset.channels[0].noise = step_m / 12_f64.sqrt();
    let kinds = |dataset: &Dataset| {
        let answer = diagnose(dataset, &|_| {}).unwrap();
        let accepted = answer.effects.into_iter().filter(|effect| effect.accepted);
        accepted.map(|effect| (effect.kind, effect.parameters[0].value)).collect::<Vec<_>>()
    };
    assert_eq!(kinds(&dataset), []);
    dataset.channels[0].resolution = 1e-6;
    let found = kinds(&dataset);
    let [(Kind::EncoderResolution, found_m)] = found[..] else { panic!("{found:?}") };
    // The step is estimated from hundreds of its multiples.
    assert!((found_m / step_m - 1.0).abs() < 1e-3, "{found_m}");
}

#[test]
fn truth_coulomb_friction_is_recovered() {
    let answer =
        diagnose(&records_of("[springs.guide.effects.coulomb-friction]\nlevel = 7.0\n"), &|_| {}).unwrap();
    let (kind, level) = first(&answer);
    assert_eq!(kind, Kind::CoulombFriction, "{:?}", answer.attempts);
    assert!((level / 7.0 - 1.0).abs() < RECOVERY, "{level}");
    assert_eq!(answer.verdict, Verdict::Explained);
    assert_eq!(answer.places[0].place, "guide");
    assert!(answer.gap.after < answer.gap.refit && answer.gap.closed > 0.8, "{:?}", answer.gap);
    assert!((answer.effects[0].credit - 1.0).abs() < f64::EPSILON);
    assert!(answer.attempts.iter().any(|attempt| attempt.why == AttemptOutcome::Accepted));
    // A law that contains another one is not fitted worse. The evidence includes the check experiments.
    let all = |kind: &str| {
        answer
            .attempts
            .iter()
            .find(|attempt| attempt.causes == format!("{kind}@springs.guide"))
            .and_then(|a| a.gain_all)
    };
    if let (Some(outer), Some(inner)) = (all("asymmetric-friction"), all("coulomb-friction")) {
        // Allows for the cost of one more unknown, and for the check experiments, which are not fitted.
        assert!(outer > inner - 10.0, "{outer} {inner}");
    }
}

#[test]
fn truth_friction_stands_beside_damping_that_is_hardly_there() {
    let real =
        BELIEVED.replace("damping = 60.0", "damping = 3.0\neffects.coulomb-friction = { level = 7.0 }");
    let answer = diagnose(&records_between(BELIEVED, &real), &|_| {}).unwrap();
    assert_eq!(first(&answer).0, Kind::CoulombFriction, "{:?}", answer.attempts);
    // Calibration stops at an eighth of the believed damping, 7.5 N s/m. The level compensates for the rest,
    // by less than its interval.
    let [low, high] = answer.effects[0].parameters[0].ci90;
    assert!((low..high).contains(&7.0), "{low} to {high}");
    // No cause reduces damping. At the lowest value of calibration no cause can therefore be missing.
    assert_eq!(answer.verdict, Verdict::Explained, "{:?}", answer.adequacy.shortfalls);
}

#[test]
fn truth_damping_beyond_its_tolerance_is_a_finding_and_no_doubt() {
    let real = BELIEVED.replace("damping = 60.0", "damping = 300.0");
    let answer = diagnose(&records_between(BELIEVED, &real), &|_| {}).unwrap();
    assert_eq!(first(&answer).0, Kind::ViscousFriction, "{:?}", answer.attempts);
    assert_eq!(answer.verdict, Verdict::Explained, "{:?}", answer.adequacy.shortfalls);
}

/// Friction is found in any case. Damping of 2.5 times the believed one must be found too, or the answer must
/// say that it may be present. Calibration may account for half of it.
#[test]
fn truth_damping_beyond_its_tolerance_beside_friction_is_found_or_declared() {
    let real =
        BELIEVED.replace("damping = 60.0", "damping = 150.0\neffects.coulomb-friction = { level = 7.0 }");
    let answer = diagnose(&records_between(BELIEVED, &real), &|_| {}).unwrap();
    let accepted: Vec<Kind> =
        answer.effects.iter().filter(|effect| effect.accepted).map(|effect| effect.kind).collect();
    assert!(accepted.contains(&Kind::CoulombFriction), "{accepted:?}");
    let is_declared =
        answer.adequacy.shortfalls.iter().any(|shortfall| shortfall.condition == Condition::Tolerance);
    assert!(accepted.contains(&Kind::ViscousFriction) || is_declared, "{:?}", answer.adequacy);
}

/// Friction of one level and a load are together the same force as friction of two levels, at rest and in
/// motion. Whichever is hidden, neither may be sure.
#[test]
fn truth_laws_that_are_equal_share_their_probability() {
    let load = "[springs.guide.effects.coulomb-friction]\nlevel = 10.0\n\
                [springs.guide.effects.constant-load]\nforce = -4.0\n";
    let levels = "[springs.guide.effects.asymmetric-friction]\nlevel = 10.0\nasymmetry = 0.4\n";
    for effect in [load, levels] {
        let answer = diagnose(&records_on(BELIEVED_STIFF, effect), &|_| {}).unwrap();
        assert_eq!(answer.verdict, Verdict::Ambiguous, "{:?}", answer.attempts);
        let probability = |kind| {
            let found = answer.effects.iter().find(|effect| effect.kind == kind);
            found.unwrap_or_else(|| panic!("{kind}: {:?}", answer.effects)).probability
        };
        let sum = probability(Kind::AsymmetricFriction);
        for part in [Kind::CoulombFriction, Kind::ConstantLoad] {
            assert!(
                answer.look_alikes.contains(&[part, Kind::AsymmetricFriction]),
                "{:?}",
                answer.look_alikes
            );
            // The fits end within a fraction of a nat of each other.
            assert!((probability(part) - sum).abs() < 0.1, "{part}: {} {sum}", probability(part));
        }
    }
}

#[test]
fn truth_a_resonance_is_flexibility_and_not_delay() {
    let effect = "[springs.transmission.effects.transmission-flexibility]\nstiffness = 9.0e5\ndamping = \
                  80.0\ntip_mass = 5.0\n";
    let answer = diagnose(&records_of(effect), &|_| {}).unwrap();
    let (kind, stiffness) = first(&answer);
    assert_eq!(kind, Kind::TransmissionFlexibility, "{:?}", answer.attempts);
    assert!((stiffness / 9.0e5 - 1.0).abs() < RECOVERY, "{stiffness}");
    assert!(answer.effects.iter().all(|effect| !(effect.accepted && effect.kind == Kind::CommandDelay)));
}

/// Neither the frequency of the mode within its range nor its low damping may matter. It is at 43.4 Hz with 1
/// % damping, and splits one body.
#[test]
fn regress_a_soft_joint_that_hardly_damps_is_found_by_a_motor_encoder_alone() {
    let effect = "[bodies.motor.effects.transmission-flexibility]\nstiffness = 2.0e5\ndamping = \
                  14.7\ntip_mass = 4.0\n";
    let answer = diagnose(&records_on(BELIEVED_STIFF, effect), &|_| {}).unwrap();
    let (kind, stiffness) = first(&answer);
    assert_eq!(kind, Kind::TransmissionFlexibility, "{:?}", answer.attempts);
    assert!((stiffness / 2.0e5 - 1.0).abs() < RECOVERY, "{stiffness}");
    // All applicable effects of the library are reported, including those that nothing indicated.
    for tried in [
        "base-flexibility@springs.guide",
        "force-ripple@actuators.drive",
        "coulomb-friction@springs.guide",
        "added-mass@bodies.motor",
    ] {
        assert!(
            answer
                .attempts
                .iter()
                .any(|attempt| attempt.causes == tried && !attempt.why.to_string().is_empty()),
            "{tried}"
        );
    }
}

/// A drive that is wired the wrong way round.
#[test]
fn truth_a_negative_gain_is_a_reversed_sign_and_no_plausible_gain() {
    let answer =
        diagnose(&records_of("[actuators.drive.effects.drive-gain]\ngain = -1.05\n"), &|_| {}).unwrap();
    let (kind, gain) = first(&answer);
    assert_eq!(kind, Kind::DriveGain, "{:?}", answer.attempts);
    assert!((gain / -1.05 - 1.0).abs() < 0.1, "{gain}");
    assert_ne!(answer.verdict, Verdict::Explained);
    let [said] = answer.contradictions.as_slice() else { panic!("{:?}", answer.contradictions) };
    assert!(
        said.starts_with("`command`: has the opposite sign") && said.contains("reverse the sign"),
        "{said}"
    );
    let is_doubted =
        |short: &Shortfall| short.condition == Condition::Plausible && short.what.contains("sign");
    assert!(answer.adequacy.shortfalls.iter().any(is_doubted), "{:?}", answer.adequacy.shortfalls);
}

#[test]
fn truth_a_delay_is_delay_and_not_flexibility() {
    let answer =
        diagnose(&records_of("[actuators.drive.effects.command-delay]\ndelay = 1.6e-3\n"), &|_| {}).unwrap();
    let (kind, delay) = first(&answer);
    assert_eq!(kind, Kind::CommandDelay, "{:?}", answer.attempts);
    assert!((delay / 1.6e-3 - 1.0).abs() < RECOVERY, "{delay}");
}

#[test]
fn truth_without_an_effect_there_is_no_gap() {
    let answer = diagnose(&records_of(""), &|_| {}).unwrap();
    assert_eq!(answer.verdict, Verdict::NoGap, "{:?} {:?}", answer.effects, answer.adequacy.shortfalls);
    assert!(answer.effects.iter().all(|effect| !effect.accepted));
    assert!(!answer.cells.is_empty() && !answer.ladder.is_empty());
}
