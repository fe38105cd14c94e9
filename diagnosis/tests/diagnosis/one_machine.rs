//! The predictor and the engine give the same motion for the same commands. They use different exponentials
//! and root finders, but the same hybrid semantics ([`feeler_plant::motion::modes`]).
//!
//! Tolerance. Both locate events to 1e-15 s and advance states to machine precision: 1e-14 of the motion per
//! row, over up to 8e4 rows. [`AGREEMENT`], relative to the largest value, allows for that. Some motions
//! amplify errors: a guide that breaks loose under friction that falls with speed, or a series of impacts.
//! For such a motion the tolerance is its change if it starts [`NUDGE_M_PER_S`] faster. The predictor's
//! extrapolation ends at 1e-13 of the sum of the magnitudes of all speed changes in a row, about 0.01 m/s.
//! That is 1e-15 m/s per row and 4e-12 m/s over 4e3 rows. A missed event, a law with the wrong sign or a
//! delay of a row causes an error of at least 1e-4.

use std::path::Path;

use feeler_diagnosis::dataset::{Channel, Dataset, Driven, Looped, Record};
use feeler_diagnosis::predict::Predictor;
use feeler_diagnosis::replay::replay_record;
use feeler_engine::{Program, Scenario, Simulation, Trace};
use feeler_files::Document;
use feeler_plant::assembly::{assemble, resolve};
use feeler_plant::description::{Quantity, SignalName};

/// Largest difference between engine and predictor, over the largest value of a signal, if the motion is well
/// conditioned.
const AGREEMENT: f64 = 1e-9;
/// Change of the initial speed that shows how much the motion amplifies errors, m/s.
const NUDGE_M_PER_S: f64 = 1e-11;
/// Difference between the two starts, as a share of a signal's size, at which the motion counts as chaotic.
const LOST: f64 = 1e-3;
/// Commands of every scenario change only on this grid, so that each row holds one command.
const ROWS_PER_S: f64 = 1e4;

fn scenario(text: &str) -> Scenario {
    Document::parse(text, "machine.toml").expect("the text is a machine").scenario
}

/// A simulated run as a dataset. It has positions and speeds of all bodies, forces of all contacts and
/// drives, and the commands.
fn recorded(scenario: &Scenario) -> Dataset {
    let commands = scenario.machine.actuators.keys().map(|drive| SignalName::new(drive, Quantity::Command));
    recorded_with(scenario, commands.collect())
}

/// A simulated run with other signals in place of the drives' commands.
fn recorded_with(scenario: &Scenario, commands: Vec<SignalName>) -> Dataset {
    let machine = &scenario.machine;
    let signals: Vec<SignalName> = (machine.bodies.keys())
        .flat_map(|body| [Quantity::Position, Quantity::Velocity].map(|what| SignalName::new(body, what)))
        .chain(machine.contacts.keys().map(|contact| SignalName::new(contact, Quantity::Force)))
        .chain(machine.actuators.keys().map(|drive| SignalName::new(drive, Quantity::Force)))
        .collect();
    let mut scenario = scenario.clone();
    scenario.run.record = signals.iter().cloned().chain(commands).collect();
    scenario.run.record_rate_hz = Some(ROWS_PER_S);
    let program = Program::new(&scenario).expect("the scenario is sound");
    let mut trace = Trace::new(program.record_names());
    let mut simulation = Simulation::<f64>::new(vec![program]).expect("it moves");
    simulation.run(&mut trace).expect("it runs");
    let (series, commands) = trace.columns.split_at(signals.len());
    let channels = signals.iter().map(|signal| Channel {
        column: signal.to_string(),
        source: resolve(&scenario.machine, signal).expect("the machine has the signal"),
        noise: 0.0,
        resolution: 0.0,
    });
    let record = Record::even("run.csv", 1.0 / ROWS_PER_S, commands.to_vec(), series.to_vec());
    let record = Record { is_check: true, times_s: trace.t_s.clone(), ..record };
    let driven = |drive| Driven {
        drive,
        column: format!("command-{drive}"),
        hold_s: Some(1.0 / ROWS_PER_S),
        noise: None,
    };
    let drives = (0..commands.len()).map(driven).collect();
    let channels = channels.collect();
    Dataset::new("run", scenario.machine, drives, channels, vec![record])
}

/// Predicted motion of a dataset's machine under its commands, with all initial speeds raised by
/// `faster_m_per_s`.
fn predicted(dataset: &Dataset, faster_m_per_s: f64) -> Vec<Vec<f64>> {
    let mut assembly = assemble(&dataset.machine).expect("it assembles");
    for node in assembly.nodes.iter_mut().skip(1) {
        node.velocity_m_per_s += faster_m_per_s;
    }
    let own = Predictor::new(assembly, dataset, &dataset.records[0]);
    own.and_then(|mut own| own.free()).expect("it moves").series
}

/// The largest difference between the free prediction and the run, over its tolerance, with the signal and
/// the row. They are compared up to the row at which the motion becomes chaotic.
fn disagreement(dataset: &Dataset) -> (f64, String) {
    let run = &dataset.records[0].series;
    let [own, nudged] = [0.0, NUDGE_M_PER_S].map(|faster| predicted(dataset, faster));
    let sizes: Vec<f64> =
        run.iter().map(|of| of.iter().fold(f64::MIN_POSITIVE, |size, x| size.max(x.abs()))).collect();
    let mut parted = vec![0.0_f64; run.len()];
    let mut worst = (0.0, String::new());
    for k in 0..run[0].len() {
        for (c, parted) in parted.iter_mut().enumerate() {
            *parted = parted.max((nudged[c][k] - own[c][k]).abs());
        }
        if parted.iter().zip(&sizes).any(|(parted, size)| *parted > LOST * size) {
            assert!(5 * k > run[0].len(), "the start is forgotten after {k} rows");
            break;
        }
        for (c, channel) in dataset.channels.iter().enumerate() {
            let (a, b) = (run[c][k], own[c][k]);
            let share = (a - b).abs() / (AGREEMENT * sizes[c] + parted[c]);
            if !share.is_finite() || share > worst.0 {
                let column = &channel.column;
                worst =
                    (share, format!("{column} at row {k}: {a:e} run, {b:e} predicted, of {:e}", sizes[c]));
            }
        }
    }
    worst
}

#[test]
fn truth_every_chatter_scenario_is_predicted_as_it_runs() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/chatter");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 6, "{files:?}");
    for file in files {
        let dataset = recorded(&Document::load(&file).expect("the scenario is sound").scenario);
        let (worst, place) = disagreement(&dataset);
        assert!(worst < 1.0, "{}: {worst:e} of what it may be, {place}", file.display());
    }
}

/// A slider on a guide with these keys, pushed by a wave of this amplitude and frequency for a second.
fn pushed(mass: &str, guide: &str, [amplitude, frequency]: [&str; 2]) -> Dataset {
    recorded(&scenario(&format!(
        r#"
        name = "slider"
        [bodies.slider]
        mass = "{mass}"
        [springs.guide]
        between = ["ground", "slider"]
        {guide}
        [actuators.drive]
        on = "slider"
        kind = "force"
        [controllers.push]
        law = "open-loop"
        drives = "drive"
        period = "1 ms"
        [controllers.push.reference]
        kind = "chirp"
        amplitude = "{amplitude}"
        start = "{frequency}"
        end = "{frequency}"
        duration = "2 s"
        [run]
        duration = "1 s"
        "#
    )))
}

/// A light body under heavy friction, many times the force that would move the body alone, so that sticking
/// decides everything. With a spring between friction and body in the predictor only, the two differed by a
/// factor of two.
#[test]
fn regress_run_and_replay_agree_for_a_light_body_under_heavy_friction() {
    let dataset = pushed(
        "50 g",
        r#"
        stiffness = "2 kN/m"
        [springs.guide.effects.coulomb-friction]
        level = "20 N"
        "#,
        ["30 N", "3 Hz"],
    );
    let replay = replay_record(&dataset.machine, &dataset, 0).expect("it moves");
    for error in &replay.errors {
        assert!(error.largest <= AGREEMENT * error.scale, "{}: {error:?}", error.column);
    }
    // The guide does slide, by (30 - 20) N over 2 kN/m.
    let reached = dataset.records[0].series[0].iter().fold(0.0_f64, |x, y| x.max(*y));
    assert!((reached - 5e-3).abs() < 1e-3, "{reached}");
}

/// A guide that yields by a tenth of its stroke: `run`, `replay` and the prediction use one law.
#[test]
fn truth_a_guide_that_yields_before_it_slides_is_predicted_as_it_runs() {
    let guide = r#"
        damping = "5 N s/m"
        [springs.guide.effects.stribeck-friction]
        coulomb = "4 N"
        static = "6 N"
        velocity = "20 mm/s"
        [springs.guide.effects.presliding]
        stiffness = "20 kN/m"
        "#;
    // Below the friction, where only the bristles move, and above.
    for (amplitude, reached) in [("3 N", 1e-5..3e-4), ("9 N", 3e-4..1.0)] {
        let dataset = pushed("500 g", guide, [amplitude, "7 Hz"]);
        let (worst, place) = disagreement(&dataset);
        assert!(worst < 1.0, "{amplitude}: {worst:e} of what it may be, {place}");
        let most = dataset.records[0].series[0].iter().fold(0.0_f64, |x, y| x.max(y.abs()));
        assert!(reached.contains(&most), "{amplitude}: {most}");
    }
}

/// Bristles that straighten in a fifth of a row and are damped. Their rate at the start of a row, held over
/// it, grew from row to row until the prediction diverged.
#[test]
fn regress_damped_bristles_that_slide_fast_are_predicted_as_they_run() {
    let dataset = pushed(
        "200 g",
        r"
        damping = 20.0
        [springs.guide.effects.lugre-friction]
        stiffness = 5.0e5
        damping = 3000.0
        coulomb = 4.0
        static = 7.0
        velocity = 5.0e-3
        ",
        ["15 N", "2 Hz"],
    );
    let own = predicted(&dataset, 0.0);
    for ((run, own), channel) in dataset.records[0].series.iter().zip(&own).zip(&dataset.channels) {
        let size = run.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        let apart = run.iter().zip(own).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        // The mean of the friction over a row is of second order; a row moves the slider by a third of the
        // way over which bristles bend.
        assert!(apart < 0.01 * size, "{}: {apart:e} of {size:e}", channel.column);
    }
    let fast = dataset.records[0].series[1].iter().fold(0.0_f64, |fast, v| fast.max(v.abs()));
    assert!(fast > 0.3, "{fast}");
}

/// A linear congruential generator (Knuth): equal machines on every computer.
struct Draw(u64);

impl Draw {
    /// Uniform between zero and one.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in the logarithm.
    fn log(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.share())
    }

    fn one_of<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[(self.share() * of.len() as f64) as usize]
    }
}

/// A machine of two bodies before a wall, with random friction, play, contact law and drive.
fn machine(draw: &mut Draw) -> String {
    let (motor, tip) = (draw.log(0.5, 10.0), draw.log(0.5, 10.0));
    let friction = match draw.one_of(&["none", "coulomb", "asymmetric", "stribeck", "load"]) {
        "coulomb" => format!("coulomb-friction]\nlevel = {}", draw.log(0.5, 10.0)),
        "asymmetric" => {
            let level = draw.log(0.5, 10.0);
            format!("asymmetric-friction]\nlevel = {level}\nasymmetry = {}", draw.share() - 0.5)
        }
        "stribeck" => {
            let sliding = draw.log(0.5, 5.0);
            format!("stribeck-friction]\ncoulomb = {sliding}\nstatic = {}\nvelocity = 0.01", 1.5 * sliding)
        }
        "load" => format!("load-friction]\nratio = {}", draw.log(0.02, 0.3)),
        _ => String::new(),
    };
    let friction =
        if friction.is_empty() { friction } else { format!("[springs.guide.effects.{friction}\n") };
    let play = match draw.one_of(&["none", "none", "play"]) {
        "play" => format!("[springs.joint.effects.backlash]\nwidth = {}\n", draw.log(2e-5, 3e-4)),
        _ => String::new(),
    };
    let (law, size) = match draw.one_of(&["kelvin-voigt", "kelvin-voigt", "hertz", "hunt-crossley"]) {
        "hertz" => ("law = \"hertz\"", 100.0),
        "hunt-crossley" => ("law = \"hunt-crossley\"\nalpha = 0.8", 100.0),
        _ => ("law = \"kelvin-voigt\"", 1.0),
    };
    let damping = if law.contains("hunt") { 0.0 } else { draw.log(20.0, 300.0) };
    let slew = match draw.one_of(&["none", "none", "slew"]) {
        "slew" => format!("[actuators.drive.effects.slew-limit]\nrate = {}\n", draw.log(300.0, 3000.0)),
        _ => String::new(),
    };
    format!(
        r#"
        name = "drawn"
        [bodies.motor]
        mass = {motor}
        [bodies.tip]
        mass = {tip}
        [springs.guide]
        between = ["ground", "motor"]
        damping = {guide}
        {friction}
        [springs.joint]
        between = ["motor", "tip"]
        stiffness = {stiffness}
        damping = {joint}
        {play}
        [contacts.wall]
        between = ["tip", "ground"]
        {law}
        stiffness = {wall}
        {damping}
        gap = {gap}
        [actuators.drive]
        on = "motor"
        kind = "force"
        limit = "60 N"
        {slew}
        [controllers.push]
        law = "open-loop"
        drives = "drive"
        period = "1 ms"
        reference = {{ kind = "chirp", amplitude = {push}, start = {from}, end = {to}, duration = "1 s" }}
        [run]
        duration = "0.4 s"
        "#,
        guide = draw.log(5.0, 80.0),
        stiffness = draw.log(3e4, 2e6),
        joint = draw.log(10.0, 200.0),
        wall = size * draw.log(2e4, 4e5),
        damping = if damping > 0.0 { format!("damping = {damping}") } else { String::new() },
        gap = draw.log(1e-4, 2e-3),
        push = draw.log(10.0, 80.0),
        from = draw.log(1.0, 5.0),
        to = draw.log(5.0, 30.0),
    )
}

/// Number of random machines.
const DRAWN: usize = 40;

#[test]
fn prop_drawn_machines_are_predicted_as_they_run() {
    let mut draw = Draw(17);
    let mut touched = 0;
    for i in 0..DRAWN {
        let text = machine(&mut draw);
        let dataset = recorded(&scenario(&text));
        let (worst, place) = disagreement(&dataset);
        assert!(worst < 1.0, "machine {i}: {worst:e} of what it may be, {place}\n{text}");
        let force = dataset.channels.iter().position(|channel| channel.column == "wall.force").unwrap();
        touched += usize::from(dataset.records[0].series[force].iter().any(|force| *force > 0.0));
    }
    assert!(2 * touched > DRAWN, "only {touched} of {DRAWN} touched the wall");
}

/// A servo with two further inputs, the speed of its target and a force. They arrive at different times.
fn fed(servo: &str) -> String {
    let input = |name: &str, kind: &str, delay_s: f64, first: f64| {
        format!(
            "[actuators.{name}]\non = \"axis\"\nkind = \"{kind}\"\n\
             [actuators.{name}.effects.command-delay]\ndelay = {delay_s}\n\
             [controllers.{name}]\nlaw = \"open-loop\"\ndrives = \"{name}\"\nperiod = 0.01\n\
             reference = [[0.0, {first}], [0.1, 0.0], [0.3, {}]]\n",
            -0.5 * first
        )
    };
    let [speed, force] =
        [input("speed", "target-velocity", 0.0023, 0.6), input("lead", "feed-forward", 0.0, 4.0)];
    format!("{servo}\n{speed}{force}")
}

/// Every kind of drive with a control loop, a winding or an imposed motion, and with every switching law. The
/// loops run inside the prediction as they run in the machine.
#[test]
fn truth_servos_motors_and_imposed_motions_are_predicted_as_they_run() {
    let cases = [
        "kind = \"position-servo\"\nkp = 900.0\nkd = 14.0\nki = 500.0\nlimit = 12.0\n\
         error_deadband = 0.002\ndelay = 0.0131",
        "kind = \"position-servo\"\nkp = 900.0\nkd = 14.0\nvelocity_limit = 0.4\n\
         [actuators.drive.effects.actuator-lag]\ntime_constant = 0.003",
        "kind = \"position-servo\"\nkp = 700.0\nkd = 20.0\nki = 300.0\nlimit = 9.0\n\
         period = 0.0025\ncompute_delay = 0.0008\n\
         resolution = 1e-4\noutput_resolution = 0.05\nerror_deadband = 0.001\n\
         velocity_limit = 0.5\ndelay = 0.0061",
        "kind = \"position-servo\"\nkp = 900.0\nkd = 14.0\n\
         [actuators.drive.effects.command-interpolation]\ninterval = 0.07",
        "kind = \"position-servo\"\nkp = 700.0\nkd = 20.0\nperiod = 0.0025\ndelay = 0.0061\n\
         [actuators.drive.effects.command-interpolation]\ninterval = 0.05",
        &fed("kind = \"position-servo\"\nkp = 900.0\nkd = 14.0\nki = 300.0\nlimit = 12.0"),
        &fed("kind = \"position-servo\"\nkp = 700.0\nkd = 20.0\nki = 300.0\nlimit = 9.0\nperiod = 0.0025"),
        "kind = \"position-servo\"\nkp = 900.0\nkd = 14.0\nlimit = 12.0\n\
         [actuators.drive.effects.thermal-derating]\nforce = 6.0\ntime_constant = 0.2",
        "kind = \"dc-motor\"\nresistance = 2.0\ntorque_constant = 0.5\ngear_ratio = 4.0\n\
         [actuators.drive.effects.thermal-derating]\nforce = 10.0\ntime_constant = 0.1",
        "kind = \"dc-motor\"\nresistance = 2.0\ntorque_constant = 0.5\ninductance = 0.01\n\
         gear_ratio = 4.0\ncurrent_limit = 3.0\nsupply_voltage = 9.0",
        "kind = \"dc-motor\"\ninput = \"current\"\nresistance = 2.0\ntorque_constant = 0.5\n\
         gear_ratio = 4.0\nsupply_voltage = 4.0",
    ];
    for (case, drive) in cases.iter().enumerate() {
        let sizes = if drive.contains("servo") { [0.05, -0.03, 0.001] } else { [6.0, -8.0, 1.0] };
        let [a, b, c] = sizes;
        let text = format!(
            "[bodies.axis]\nmass = 1.5\n[springs.guide]\nbetween = [\"ground\", \"axis\"]\ndamping = 2.0\n\
             [springs.guide.effects.coulomb-friction]\nlevel = 0.7\n\
             [actuators.drive]\non = \"axis\"\n{drive}\n\
             [controllers.aim]\nlaw = \"open-loop\"\ndrives = \"drive\"\nperiod = 0.01\n\
             reference = [[0.0, 0.0], [0.05, {a}], [0.25, {b}], [0.5, {c}]]\n\
             [run]\nduration = 0.8\nstep = 1e-4\n"
        );
        let (worst, place) = disagreement(&recorded(&scenario(&text)));
        assert!(worst < 1.0, "case {case}: {worst:e} of what it may be, {place}");
    }
    let imposed = "[bodies.rig]\nmass = 3.0\n[bodies.axis]\nmass = 1.5\n\
         [springs.rope]\nbetween = [\"rig\", \"axis\"]\n\
         stiffness = 400.0\ndamping = 1.0\n[actuators.drive]\non = \"rig\"\nkind = \"imposed\"\n\
         [controllers.aim]\n\
         law = \"open-loop\"\ndrives = \"drive\"\nperiod = 1e-4\n\
         reference = { kind = \"chirp\", amplitude = 0.02, start = 1.0, end = 6.0, duration = 0.8 }\n\
         [run]\nduration = 0.5\nstep = 1e-4\n";
    let mut dataset = recorded(&scenario(imposed));
    // At the end of a record the curvature of the last cubic is unknown.
    dataset.records[0].series.iter_mut().for_each(|series| series.truncate(4990));
    dataset.records[0].commands.iter_mut().for_each(|commands| commands.truncate(4995));
    dataset.records[0].times_s.truncate(4990);
    // The acceleration, and with it the drive's force, jumps at every knot. Every row lies on a knot, and the
    // rounding of its time decides on which side.
    let force = dataset.channels.iter().position(|channel| channel.column == "drive.force").unwrap();
    dataset.channels.remove(force);
    dataset.records[0].series.remove(force);
    dataset.records[0].silent.remove(force);
    let (worst, place) = disagreement(&dataset);
    assert!(worst < 1.0, "imposed: {worst:e} of what it may be, {place}");
}

/// A controller from the file, with the recorded reference.
#[test]
fn truth_controllers_run_in_the_prediction_as_in_the_machine() {
    let force = "law = \"explicit-force\"\nreads = \"force\"\nfeed_forward = 1.0\nkp = 0.3\nki = 10.0\n\
         damping = 90.0\napproach = { speed = \"20 mm/s\", until = \"2 N\" }\n\
         reference = [[0.0, 5.0], [0.3, 12.0]]";
    let position = "law = \"position\"\nreads = \"encoder\"\nkp = 4000.0\nki = 9000.0\ndamping = 150.0\n\
         output_limit = 40.0\nreference = [[0.0, 0.0], [0.1, 0.0015], [0.3, -0.004]]";
    let late = "[actuators.drive.effects.command-delay]\ndelay = 0.0013\n\
         [actuators.drive.effects.drive-gain]\ngain = 0.9\n";
    for (case, (law, effects)) in [(force, ""), (force, late), (position, late)].into_iter().enumerate() {
        let text = format!(
            "[bodies.axis]\nmass = 5.0\n[springs.guide]\nbetween = [\"ground\", \"axis\"]\ndamping = 50.0\n\
             [springs.guide.effects.coulomb-friction]\nlevel = 0.7\n\
             [contacts.tool]\nbetween = [\"axis\", \"ground\"]\nstiffness = 2e4\ndamping = 60.0\n\
             gap = 0.001\n\
             [actuators.drive]\non = \"axis\"\nkind = \"force\"\n{effects}\
             [sensors.force]\nreads = \"tool.spring_force\"\ndelay = 0.0007\nresolution = 0.01\n\
             [sensors.encoder]\nreads = \"axis.position\"\n\
             [controllers.loop]\ndrives = \"drive\"\nperiod = 0.001\ndelay = 0.0004\n{law}\n\
             [run]\nduration = 0.5\nstep = 1e-4\n"
        );
        let scenario = scenario(&text);
        let mut dataset = recorded_with(&scenario, vec![SignalName::new("loop", Quantity::Reference)]);
        let used = &scenario.controllers["loop"];
        let sensor = |name: Option<&str>| name.and_then(|name| scenario.machine.sensors.get_index_of(name));
        dataset.loops.push(Looped {
            name: "loop".into(),
            drive: 0,
            spec: used.spec.clone(),
            reading: sensor(used.reads.as_deref()),
            motion: sensor(used.motion_sensor(&scenario.machine)),
            motion_is_velocity: false,
        });
        let (worst, place) = disagreement(&dataset);
        assert!(worst < 1.0, "case {case}: {worst:e} of what it may be, {place}");
    }
}
