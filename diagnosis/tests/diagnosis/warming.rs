//! A drive that weakens as it warms, hidden in long logs, with and without pauses.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::fs;

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::report::Verdict;
use feeler_diagnosis::{Diagnosis, diagnose};
use feeler_engine::{Program, Simulation, Trace};
use feeler_files::Document;
use feeler_plant::effects::Kind;

const SPACING_S: f64 = 0.02;
const LINES: u32 = 12;
const FORCE_N: f64 = 25.0;
const TIME_CONSTANT_S: f64 = 15.0;
/// About thirty times the uncertainty due to noise of 2 um in motions of centimetres. Between records the
/// heat is computed from rows.
const RECOVERY: f64 = 0.05;

/// Share of the error beyond the noise that the cause removes. The rest is due to heat changes between rows.
const CLOSED: f64 = 0.9;

const AXIS: &str = "[bodies.axis]\nmass = 2.0\n[springs.guide]\nbetween = [\"ground\", \"axis\"]\n\
    damping = 60.0\n[sensors.encoder]\nreads = \"axis.position\"\nnoise = 2e-6\n\
    [actuators.drive]\non = \"axis\"\nkind = \"force\"\n";

/// Sines from 0.5 to 6 Hz that do not repeat within a log.
fn sines(t: f64) -> f64 {
    let line = |i: u32| {
        let i = f64::from(i);
        let hz = 0.5 * 12_f64.powf(i / f64::from(LINES - 1));
        (TAU * hz * t - PI * i * i / f64::from(LINES)).sin()
    };
    (0..LINES).map(line).sum()
}

/// Simulates the warming drive without a break, and keeps the rows of `parts`, `[first, end]`, as experiments
/// on its clock. In between the drive rests.
fn logged(parts: &[[usize; 2]]) -> Dataset {
    let rows = parts.iter().map(|part| part[1]).max().expect("a part");
    let is_logged = |k: usize| parts.iter().any(|[first, end]| (*first..*end).contains(&k));
    let command = |k: usize| if is_logged(k) { 9.0 * sines(k as f64 * SPACING_S) } else { 0.0 };
    let points = (0..rows).map(|k| format!("[{}, {:e}]", k as f64 * SPACING_S, command(k)));
    let text = format!(
        "{AXIS}[actuators.drive.effects.thermal-derating]\nforce = {FORCE_N}\n\
         time_constant = {TIME_CONSTANT_S}\n\
         [controllers.aim]\nlaw = \"open-loop\"\ndrives = \"drive\"\nperiod = {SPACING_S}\n\
         reference = [{}]\n[run]\nduration = {}\nrecord = [\"drive.command\", \"encoder.reading\"]\n\
         record_rate = {}\n",
        points.collect::<Vec<_>>().join(", "),
        (rows - 1) as f64 * SPACING_S,
        1.0 / SPACING_S
    );
    let scenario = Document::parse(&text, "real.toml").expect("a scenario").scenario;
    let program = Program::new(&scenario).expect("it is sound");
    let mut trace = Trace::new(program.record_names());
    Simulation::<f64>::new(vec![program]).expect("it moves").run(&mut trace).expect("it runs");
    let folder = tempfile::tempdir().expect("a folder");
    let mut dataset = format!(
        "machine = \"machine.toml\"\n[columns.u]\nsignal = \"drive.command\"\nhold = {SPACING_S}\n\
         [columns.y]\nsignal = \"encoder.reading\"\n"
    );
    for (i, part) in parts.iter().enumerate() {
        let mut rows = "t_s,u,y\n".to_owned();
        for k in part[0]..part[1] {
            let t = k as f64 * SPACING_S;
            let _ = writeln!(rows, "{t:e},{:e},{:e}", trace.columns[0][k], trace.columns[1][k]);
        }
        fs::write(folder.path().join(format!("r{i}.csv")), rows).expect("written");
        let role = if i == 1 { "check" } else { "fit" };
        let _ = write!(dataset, "[[experiments]]\nfile = \"r{i}.csv\"\nrole = \"{role}\"\n");
    }
    fs::write(folder.path().join("machine.toml"), AXIS).expect("written");
    fs::write(folder.path().join("dataset.toml"), dataset).expect("written");
    Dataset::load(folder.path()).unwrap_or_else(|error| panic!("{error}"))
}

fn is_found(answer: &Diagnosis) {
    let found: Vec<_> = answer.effects.iter().filter(|effect| effect.accepted).collect();
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].kind, Kind::ThermalDerating, "{:?}", answer.attempts);
    for ((name, found), value) in found[0].parameters.iter().zip([FORCE_N, TIME_CONSTANT_S]) {
        assert!((found.value / value - 1.0).abs() < RECOVERY, "{name} {}", found.value);
    }
    // A balance of forces does not involve a derating, so the answer may stay ambiguous with other causes at
    // the drive.
    let is_sound = matches!(answer.verdict, Verdict::Explained | Verdict::Ambiguous);
    assert!(is_sound, "{:?}: {:?}", answer.verdict, answer.adequacy.shortfalls);
    assert!(answer.gap.closed > CLOSED, "{:?}", answer.gap);
}

#[test]
fn truth_a_derating_is_recovered_from_the_pieces_of_one_log() {
    let whole = logged(&[[0, 3000]]).in_pieces();
    assert_eq!(whole.records.len(), 9);
    is_found(&diagnose(&whole, &|_| {}).expect("a diagnosis"));
}

/// Pauses of 12 s, in which a winding keeps 45 % of its heat.
#[test]
fn truth_a_derating_is_recovered_over_the_pauses_of_a_log() {
    let paused = logged(&[[0, 1500], [2100, 3600], [4200, 5700]]);
    assert!(paused.records[1].before.is_some() && paused.records[2].before.is_some());
    is_found(&diagnose(&paused, &|_| {}).expect("a diagnosis"));
}
