//! Records of a servo, of a motor and of an imposed motion, from the folder to the answer. The diagnosis
//! finds the effect hidden at each drive, and its size.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::fs;

use feeler_diagnosis::dataset::{Channel, Dataset, Driven, Record};
use feeler_diagnosis::predict::Predictor;
use feeler_diagnosis::report::Verdict;
use feeler_diagnosis::{Diagnosis, diagnose};
use feeler_engine::{Program, Simulation, Trace};
use feeler_files::Document;
use feeler_plant::assembly::{Source, assemble};
use feeler_plant::description::Quantity;
use feeler_plant::effects::Kind;

const SPACING_S: f64 = 2e-3;
const ROWS: usize = 800;
/// Number of sines of a command.
const LINES: u32 = 12;
/// About ten times the uncertainty due to noise of 2 um in these records of 20 mm.
const RECOVERY: f64 = 0.03;

/// One body on a guide; the actuator's table follows.
const AXIS: &str = "[bodies.axis]\nmass = 2.0\n[springs.guide]\nbetween = [\"ground\", \"axis\"]\n\
    damping = 20.0\n[sensors.encoder]\nreads = \"axis.position\"\nnoise = 2e-6\n\
    [actuators.drive]\non = \"axis\"\n";
const SERVO: &str = "kind = \"position-servo\"\nkp = 3000.0\nkd = 60.0\n";
const FRICTION: &str = "[springs.guide.effects.coulomb-friction]\nlevel = 3.0\n";

/// Command of a drive: largest value, highest frequency, and number of rows for which each value is held.
#[derive(Clone, Copy)]
struct Commanded {
    peak: f64,
    high_hz: f64,
    held: usize,
}

/// Sines from 0.8 Hz upwards, with phases after Schroeder plus `turn` per line.
fn multisine(command: Commanded, turn: f64) -> Vec<f64> {
    let last = f64::from(LINES - 1);
    let sines = |t: f64| -> f64 {
        (0..LINES)
            .map(f64::from)
            .map(|i| {
                let hz = 0.8 * (command.high_hz / 0.8).powf(i / last);
                (TAU * hz * t - PI * i * i / f64::from(LINES) + turn * i).sin()
            })
            .sum()
    };
    let raw: Vec<f64> =
        (0..ROWS).map(|k| sines((k / command.held * command.held) as f64 * SPACING_S)).collect();
    let largest = raw.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    raw.iter().map(|x| command.peak * x / largest).collect()
}

/// Shares of the largest command of two fit records and one check record, with the turns of their phases.
const RECORDS: [(f64, f64, &str); 3] = [(1.0, 0.0, "fit"), (0.4, 0.7, "fit"), (0.8, 1.9, "check")];

/// The answer for multisines.
fn diagnosed(believed: &str, effect: &str, signal: &str, command: Commanded) -> Diagnosis {
    let of = |share, turn| multisine(Commanded { peak: share * command.peak, ..command }, turn);
    diagnosed_under(believed, effect, signal, &of)
}

/// Two fit records and one check record of `believed` with `effect`, diagnosed with the machine `believed`.
/// `command` gives the command of a record.
fn diagnosed_under(
    believed: &str,
    effect: &str,
    signal: &str,
    command: &dyn Fn(f64, f64) -> Vec<f64>,
) -> Diagnosis {
    let folder = tempfile::tempdir().expect("a folder");
    let mut dataset = format!(
        "machine = \"machine.toml\"\n[columns.u]\nsignal = \"{signal}\"\nhold = {SPACING_S}\n\
         [columns.y]\nsignal = \"encoder.reading\"\n"
    );
    for (i, (share, turn, role)) in RECORDS.into_iter().enumerate() {
        let values = command(share, turn);
        let points = values.iter().enumerate().map(|(k, u)| format!("[{}, {u:e}]", k as f64 * SPACING_S));
        let text = format!(
            "{believed}{effect}[controllers.aim]\nlaw = \"open-loop\"\ndrives = \"drive\"\n\
             period = {SPACING_S}\nreference = [{}]\n\
             [run]\nduration = {}\nseed = {i}\nrecord = [\"drive.command\", \"encoder.reading\"]\n\
             record_rate = {}\n",
            points.collect::<Vec<_>>().join(", "),
            (values.len() - 1) as f64 * SPACING_S,
            1.0 / SPACING_S
        );
        let scenario = Document::parse(&text, "real.toml").expect("a scenario").scenario;
        let program = Program::new(&scenario).expect("it is sound");
        let mut trace = Trace::new(program.record_names());
        Simulation::<f64>::new(vec![program]).expect("it moves").run(&mut trace).expect("it runs");
        let mut rows = "t_s,u,y\n".to_owned();
        for (k, t) in trace.t_s.iter().enumerate() {
            let _ = writeln!(rows, "{t:e},{:e},{:e}", trace.columns[0][k], trace.columns[1][k]);
        }
        fs::write(folder.path().join(format!("r{i}.csv")), rows).expect("written");
        let _ = write!(dataset, "[[experiments]]\nfile = \"r{i}.csv\"\nrole = \"{role}\"\n");
    }
    fs::write(folder.path().join("machine.toml"), believed).expect("written");
    fs::write(folder.path().join("dataset.toml"), dataset).expect("written");
    let dataset = Dataset::load(folder.path()).unwrap_or_else(|error| panic!("{error}"));
    diagnose(&dataset, &|_| {}).expect("a diagnosis")
}

/// Asserts that the first effect has this kind and size, and that it explains the gap.
fn is_found(answer: &Diagnosis, kind: Kind, value: f64) {
    let effect = answer.effects.first().expect("an effect is named");
    assert_eq!(effect.kind, kind, "{:?}", answer.attempts);
    let found = effect.parameters[0].value;
    assert!((found / value - 1.0).abs() < RECOVERY, "{found}");
    assert_eq!(answer.verdict, Verdict::Explained, "{:?}", answer.adequacy.shortfalls);
}

#[test]
fn truth_friction_behind_a_servo_is_found_from_target_and_encoder() {
    let command = Commanded { peak: 0.02, high_hz: 12.0, held: 2 };
    let answer = diagnosed(&format!("{AXIS}{SERVO}"), FRICTION, "drive.target", command);
    is_found(&answer, Kind::CoulombFriction, 3.0);
}

#[test]
fn truth_friction_behind_a_motor_is_found_from_voltage_and_encoder() {
    let motor = "kind = \"dc-motor\"\nresistance = 1.5\ntorque_constant = 0.05\ngear_ratio = 20.0\n";
    let command = Commanded { peak: 12.0, high_hz: 12.0, held: 2 };
    let answer = diagnosed(&format!("{AXIS}{motor}"), FRICTION, "drive.voltage", command);
    is_found(&answer, Kind::CoulombFriction, 3.0);
}

/// Ripple of a strain-wave gear: twice per turn of the motor, a hundred times per turn of the joint. Over a
/// stroke of more than a turn no pitch that the records alone suggest is as short.
#[test]
fn truth_ripple_at_two_per_motor_turn_is_found_at_the_stated_gear_ratio() {
    const RATIO: f64 = 50.0;
    const AMPLITUDE: f64 = 3.0;
    let joint = format!(
        "axis = \"rotational\"\n[bodies.joint]\nmass = 0.5\n[springs.guide]\n\
         between = [\"ground\", \"joint\"]\ndamping = 5.0\n\
         [sensors.encoder]\nreads = \"joint.position\"\nnoise = 2e-6\n\
         [actuators.drive]\non = \"joint\"\nkind = \"dc-motor\"\nresistance = 1.5\n\
         torque_constant = 0.05\ngear_ratio = {RATIO}\n"
    );
    let hidden = format!(
        "[actuators.drive.effects.force-ripple]\namplitude = {AMPLITUDE}\npitch = {}\nphase = 0.4\n\
         harmonic = 2.0\n",
        TAU / RATIO
    );
    let stroke = |share: f64, turn: f64| {
        let at = |k: u32| (TAU * 0.15 * f64::from(k) * SPACING_S + turn).sin();
        (0..3000).map(|k| 24.0 * share * at(k)).collect()
    };
    let answer = diagnosed_under(&joint, &hidden, "drive.voltage", &stroke);
    is_found(&answer, Kind::ForceRipple, AMPLITUDE);
    let pitch = answer.effects[0].parameters["pitch"].value;
    assert!((pitch * RATIO * 2.0 / TAU - 1.0).abs() < 1e-3, "{pitch}");
}

#[test]
fn truth_a_mass_behind_an_imposed_motion_is_found_from_both_positions() {
    let rig = "[bodies.rig]\nmass = 1.0\n[bodies.load]\nmass = 0.5\n\
        [springs.mount]\nbetween = [\"rig\", \"load\"]\nstiffness = 500.0\ndamping = 3.0\n\
        [sensors.encoder]\nreads = \"load.position\"\nnoise = 2e-6\n\
        [actuators.drive]\non = \"rig\"\nkind = \"imposed\"\n";
    let command = Commanded { peak: 5e-3, high_hz: 12.0, held: 1 };
    let hidden = "[bodies.load.effects.added-mass]\nmass = 0.15\n";
    let answer = diagnosed(rig, hidden, "bodies.rig.position", command);
    is_found(&answer, Kind::AddedMass, 0.15);
}

#[test]
fn truth_a_resonance_behind_a_servo_is_flexibility_and_not_delay() {
    let joint =
        "[bodies.tip]\nmass = 1.5\n[springs.transmission]\nbetween = [\"axis\", \"tip\"]\nrigid = true\n";
    let hidden = "[springs.transmission.effects.transmission-flexibility]\nstiffness = 1.2e4\ndamping = 8.0\n\
        tip_mass = 1.5\n";
    let command = Commanded { peak: 0.02, high_hz: 40.0, held: 2 };
    let answer = diagnosed(&format!("{joint}{AXIS}{SERVO}"), hidden, "drive.target", command);
    is_found(&answer, Kind::TransmissionFlexibility, 1.2e4);
    assert!(answer.effects.iter().all(|effect| !(effect.accepted && effect.kind == Kind::CommandDelay)));
}

/// Largest share of a cold start's error. After four time constants 2 % of the heat remains.
const FORGOTTEN: f64 = 0.1;

/// Rows after which the estimate of a servo's first state has no effect. No command acts in the first row.
const SETTLED: usize = 30;

/// The force of a drive depends on its heat, and so does the lag of a servo.
#[test]
fn truth_a_piece_of_a_record_begins_as_warm_as_the_rows_before_left_it() {
    let heats = "[actuators.drive.effects.thermal-derating]\nforce = 40.0\ntime_constant = 1.0\n";
    let [force, servo]: [fn(i32) -> f64; 2] =
        [|k| 10.0 + 2.0 * (0.05 * f64::from(k)).sin(), |k| 0.5 * (0.02 * f64::from(k)).sin()];
    for (kind, tells, command) in [("kind = \"force\"\n", 1, force), (SERVO, 0, servo)] {
        let text = format!("{AXIS}{kind}{heats}");
        let machine = Document::parse(&text, "real.toml").expect("a machine").scenario.machine;
        let channel =
            |column: &str, source| Channel { column: column.into(), source, noise: 1e-6, resolution: 0.0 };
        let channels =
            vec![channel("encoder", Source::Sensor(0)), channel("force", Source::Drive(0, Quantity::Force))];
        let commands: Vec<f64> = (0..900).map(command).collect();
        let blank = vec![vec![0.0; commands.len()]; channels.len()];
        let drives = vec![Driven { drive: 0, column: "u".into(), hold_s: Some(0.01), noise: None }];
        let record = Record::even("long.csv", 0.01, vec![commands], blank);
        let mut dataset = Dataset::new("long", machine, drives, channels, vec![record]);
        let free = |dataset: &Dataset, record: usize| {
            let assembly = assemble(&dataset.machine).expect("it assembles");
            let moved = Predictor::new(assembly, dataset, &dataset.records[record]);
            moved.and_then(|mut moved| moved.free()).expect("it moves").series
        };
        dataset.records[0].series = free(&dataset, 0);
        let pieces = dataset.in_pieces();
        assert_eq!(pieces.records.len(), 9);
        let error = |dataset: &Dataset, i: usize| {
            let (measured, predicted) = (&dataset.records[i].series[tells], &free(dataset, i)[tells]);
            measured.iter().zip(predicted).skip(SETTLED).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        for i in 1..9 {
            let mut alone = pieces.clone();
            alone.records[i].before = None;
            let [warm, cold] = [error(&pieces, i), error(&alone, i)];
            assert!(warm < FORGOTTEN * cold, "{kind} piece {i}: {warm:e} {cold:e}");
        }
    }
}
