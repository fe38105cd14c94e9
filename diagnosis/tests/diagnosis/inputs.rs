//! Every input of a dataset moves the predicted machine as it moved the simulated one: the folder is written,
//! loaded, and predicted. The tolerance is as in `one_machine.rs`.

use std::fmt::Write as _;
use std::fs;

use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::predict::Predictor;
use feeler_engine::{Program, Simulation, Trace};
use feeler_files::Document;
use feeler_plant::assembly::assemble;

/// Largest difference between engine and predictor, over the largest value of a signal.
const AGREEMENT: f64 = 1e-9;
const ROWS_PER_S: f64 = 1e4;
/// At the end of a record the curvature of the last cubic is unknown.
const LAST_ROWS: usize = 10;

/// Simulates an axis of 1.5 kg with an actuator, and predicts it from a dataset with the signal `recorded`
/// under the name `named`.
fn replayed(actuator: &str, controller: &str, recorded: &str, named: &str) {
    let text = format!(
        "[bodies.rig]\nmass = 3.0\n[bodies.axis]\nmass = 1.5\n\
         [springs.guide]\nbetween = [\"ground\", \"rig\"]\ndamping = 2.0\n\
         [springs.rope]\nbetween = [\"rig\", \"axis\"]\nstiffness = 400.0\ndamping = 1.0\n\
         [sensors.encoder]\nreads = \"rig.position\"\n\
         [actuators.drive]\non = \"rig\"\n{actuator}\n\
         [controllers.aim]\ndrives = \"drive\"\n{controller}\n\
         [run]\nduration = 0.3\nstep = 1e-4\n"
    );
    let mut scenario = Document::parse(&text, "machine.toml").expect("a machine").scenario;
    let names = [recorded, "axis.position", "axis.velocity"];
    scenario.run.record = names.map(|name| name.parse().expect("a signal")).to_vec();
    scenario.run.record_rate_hz = Some(ROWS_PER_S);
    let program = Program::new(&scenario).expect("it is sound");
    let mut trace = Trace::new(program.record_names());
    Simulation::<f64>::new(vec![program]).expect("it moves").run(&mut trace).expect("it runs");

    let folder = tempfile::tempdir().expect("a folder");
    let mut rows = "t_s,u,x,v\n".to_owned();
    for (k, t) in trace.t_s.iter().enumerate() {
        let [u, x, v] = [0, 1, 2].map(|column| trace.columns[column][k]);
        let _ = writeln!(rows, "{t:?},{u:?},{x:?},{v:?}");
    }
    fs::write(folder.path().join("run.csv"), rows).expect("written");
    fs::write(folder.path().join("machine.toml"), text).expect("written");
    let dataset = format!(
        "machine = \"machine.toml\"\n[columns.u]\nsignal = \"{named}\"\nhold = 1e-4\n\
         [columns.x]\nsignal = \"axis.position\"\n[columns.v]\nsignal = \"axis.velocity\"\n\
         [[experiments]]\nfile = \"run.csv\"\n"
    );
    fs::write(folder.path().join("dataset.toml"), dataset).expect("written");
    let dataset = Dataset::load(folder.path()).unwrap_or_else(|error| panic!("{named}: {error}"));
    assert_eq!(dataset.drives.len(), 1, "{named}");
    let assembly = assemble(&dataset.machine).expect("it assembles");
    let predicted = Predictor::new(assembly, &dataset, &dataset.records[0])
        .and_then(|mut own| own.free())
        .expect("it moves")
        .series;
    for (c, (own, run)) in predicted.iter().zip(&dataset.records[0].series).enumerate() {
        let size = run.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        assert!(size > 1e-4, "{named}: nothing moves");
        for (k, (own, run)) in own.iter().zip(run).enumerate().take(run.len() - LAST_ROWS) {
            assert!((own - run).abs() < AGREEMENT * size, "{named}, column {c}, row {k}: {own:e} {run:e}");
        }
    }
}

/// An open-loop controller with the output `[0, 0]`, then two levels.
fn steps(levels: [f64; 2]) -> String {
    let [a, b] = levels;
    format!("law = \"open-loop\"\nperiod = 0.01\nreference = [[0.0, 0.0], [0.02, {a}], [0.15, {b}]]")
}

const MOTOR: &str = "kind = \"dc-motor\"\nresistance = 2.0\ntorque_constant = 0.5\ngear_ratio = 4.0\n\
    supply_voltage = 24.0\ninput = ";

#[test]
fn truth_a_target_leads_as_it_led_the_run() {
    let servo = "kind = \"position-servo\"\nkp = 900.0\nkd = 14.0";
    replayed(servo, &steps([0.05, -0.03]), "drive.target", "drive.target");
}

#[test]
fn truth_a_voltage_leads_as_it_led_the_run() {
    let motor = format!("{MOTOR}\"voltage\"");
    replayed(&motor, &steps([6.0, -8.0]), "drive.voltage", "drive.voltage");
}

#[test]
fn truth_a_duty_cycle_leads_as_it_led_the_run() {
    let motor = format!("{MOTOR}\"duty\"");
    replayed(&motor, &steps([0.3, -0.4]), "drive.command", "drive.command");
}

#[test]
fn regress_a_current_leads_as_it_led_the_run() {
    let motor = format!("{MOTOR}\"current\"");
    replayed(&motor, &steps([1.0, -2.0]), "drive.command", "drive.current");
}

#[test]
fn truth_the_reference_of_a_controller_leads_as_it_led_the_run() {
    let law = "law = \"position\"\nreads = \"encoder\"\nperiod = 0.001\nkp = 900.0\ndamping = 14.0\n\
        reference = [[0.0, 0.0], [0.02, 0.05], [0.15, -0.03]]";
    replayed("kind = \"force\"", law, "aim.reference", "controllers.aim.reference");
}

#[test]
fn regress_an_imposed_position_leads_as_it_led_the_run() {
    let law = "law = \"open-loop\"\nperiod = 1e-4\n\
        reference = { kind = \"chirp\", amplitude = 0.02, start = 1.0, end = 6.0, duration = 0.8 }";
    for named in ["bodies.rig.position", "rig.position"] {
        replayed("kind = \"imposed\"", law, "drive.command", named);
    }
}

/// Between rows the imposed motion is a cubic. For a sine of frequency w and rows h apart, its relative error
/// is `(w h)^4 / 720` if the speeds at the rows are exact. Speeds from neighbouring rows are too small by the
/// share `(w h)^2 / 6`, which adds ten times that error.
#[test]
fn truth_a_measured_speed_brings_an_imposed_motion_nearer_between_rows() {
    let rows_per_s = 50.0;
    let text = "[bodies.rig]\nmass = 3.0\n[bodies.axis]\nmass = 1.5\n\
         [springs.rope]\nbetween = [\"rig\", \"axis\"]\nstiffness = 4000.0\ndamping = 60.0\n\
         [actuators.drive]\non = \"rig\"\nkind = \"imposed\"\n\
         [controllers.aim]\ndrives = \"drive\"\nlaw = \"open-loop\"\nperiod = 1e-4\n\
         reference = { kind = \"chirp\", amplitude = 0.02, start = 6.0, end = 6.0, duration = 9.0 }\n\
         [run]\nduration = 2.0\nstep = 1e-4\n";
    let mut scenario = Document::parse(text, "machine.toml").expect("a machine").scenario;
    let names = ["rig.position", "rig.velocity", "axis.position"];
    scenario.run.record = names.map(|name| name.parse().expect("a signal")).to_vec();
    scenario.run.record_rate_hz = Some(rows_per_s);
    let program = Program::new(&scenario).expect("it is sound");
    let mut trace = Trace::new(program.record_names());
    Simulation::<f64>::new(vec![program]).expect("it moves").run(&mut trace).expect("it runs");
    let folder = tempfile::tempdir().expect("a folder");
    let mut rows = "t_s,p,s,x\n".to_owned();
    for (k, t) in trace.t_s.iter().enumerate() {
        let [p, s, x] = [0, 1, 2].map(|column| trace.columns[column][k]);
        let _ = writeln!(rows, "{t:?},{p:?},{s:?},{x:?}");
    }
    fs::write(folder.path().join("run.csv"), rows).expect("written");
    fs::write(folder.path().join("machine.toml"), text).expect("written");
    let error = |speed: &str| {
        let dataset = format!(
            "machine = \"machine.toml\"\n[columns.p]\nsignal = \"rig.position\"\n{speed}\
             [columns.x]\nsignal = \"axis.position\"\n[[experiments]]\nfile = \"run.csv\"\n"
        );
        fs::write(folder.path().join("dataset.toml"), dataset).expect("written");
        let dataset = Dataset::load(folder.path()).expect("it loads");
        let assembly = assemble(&dataset.machine).expect("it assembles");
        let own = Predictor::new(assembly, &dataset, &dataset.records[0]).and_then(|mut own| own.free());
        let (own, record) = (own.expect("it moves").series, &dataset.records[0]);
        let last = own.len() - 1;
        // The initial transient exp(-20 t) has faded after half of the record. At the end the last speed is
        // unknown.
        let rows = own[last].iter().zip(&record.series[last]).take(record.len() - LAST_ROWS);
        rows.skip(record.len() / 2).map(|(own, run)| (own - run).abs()).fold(0.0, f64::max)
    };
    let [without, with] = ["", "[columns.s]\nsignal = \"rig.velocity\"\n"].map(error);
    assert!(without > 5e-5, "{without}");
    assert!(with < 0.2 * without, "{with} of {without}");
}
