//! Outcomes of machines whose behaviour is known by construction. Runs are extended until they are decided,
//! as in a sweep.

use std::collections::BTreeMap;
use std::path::Path;

use feeler_files::{CellFile, Document, Draft};
use feeler_studies::run::{Outcome, PreparedRun, Summary, run_cell};

use crate::remedies::WINDUP;
use crate::why::PLAY;

/// Summary of an axis of 20 kg on a wall of 100 kN/m.
fn outcome_of(body: &str, contact: &str, drive: &str, controller: &str, duration_s: f64) -> Summary {
    let text = format!(
        "[bodies.m]\nmass = 20\n{body}\n\
         [contacts.tool]\nbetween = [\"m\", \"ground\"]\nstiffness = 1e5\n{contact}\n\
         [actuators.drive]\non = \"m\"\n{drive}\n\
         [sensors.force]\nreads = \"tool.spring_force\"\n\
         [controllers.force]\nlaw = \"explicit-force\"\nreads = \"force\"\ndrives = \"drive\"\n\
         feed_forward = 1.0\n{controller}\n\
         [run]\nduration = {duration_s}\n"
    );
    let document = Document::parse(&text, "axis.toml").unwrap_or_else(|mistakes| panic!("{mistakes}"));
    let measured = PreparedRun::new(document.scenario).and_then(|candidate| candidate.measure(0));
    measured.unwrap_or_else(|error| panic!("{error}")).summary
}

/// Closed form A of an actuator of 30 Hz, `b s + (k + b w) / w ...`, limits the gain to 0.450 with `b = 200`.
/// Sampling at 10 kHz lowers the limit to 0.4456.
const LAG: &str = "kind = \"force\"\nbandwidth = \"30 Hz\"";
const CLAMPED: &str = "engagement = \"clamped\"";
const GUIDE: &str = "[springs.guide]\nbetween = [\"ground\", \"m\"]\ndamping = 200";

/// A smooth reference excites little: over the requested duration the growth stays within the settling band.
#[test]
fn regress_growth_within_the_settling_band_is_unstable() {
    let smooth: Vec<String> = (0..=80)
        .map(|i| f64::from(i) / 80.0)
        .map(|share| format!("[{}, {}]", 0.8 * share, 10.0 * (1.0 - (std::f64::consts::PI * share).cos())))
        .collect();
    let reference = format!("period = 1e-4\nreference = [{}]", smooth.join(", "));
    for (kp, stable) in [(0.43, true), (0.46, false), (0.5, false), (0.58, false)] {
        let summary = outcome_of(GUIDE, CLAMPED, LAG, &format!("kp = {kp}\n{reference}"), 2.0);
        let expected = if stable { Outcome::Settled } else { Outcome::Unstable };
        assert_eq!(summary.outcome, expected, "kp {kp}: {:?}", summary.verdict);
    }
}

#[test]
fn regress_a_few_cycles_are_no_sustained_oscillation() {
    for (kp, duration_s, expected) in
        [(0.43, 1.0, Outcome::Undecided), (0.43, 4.0, Outcome::Settled), (0.47, 1.0, Outcome::Unstable)]
    {
        let summary = outcome_of(
            GUIDE,
            CLAMPED,
            LAG,
            &format!("kp = {kp}\nperiod = 1e-4\nreference = 20.0"),
            duration_s,
        );
        assert_eq!(summary.outcome, expected, "kp {kp}, {duration_s} s: {:?}", summary.verdict);
    }
}

/// The wall dissipates energy at every impact, under a constant push. Flights therefore become shorter,
/// whenever the run ends.
#[test]
fn regress_bouncing_that_dies_out_is_no_chatter() {
    let body = "velocity = 0.4\n[springs.guide]\nbetween = [\"ground\", \"m\"]\ndamping = 5";
    for duration_s in [0.4, 1.0, 2.6, 2.7, 2.8] {
        let summary = outcome_of(
            body,
            "damping = 100\ngap = 0.002",
            "kind = \"force\"",
            "kp = 0.1\nperiod = 1e-3\nreference = 20.0",
            duration_s,
        );
        // A run is extended eightfold at most. The motion of the shorter runs still decays then.
        let expected = if duration_s < 2.0 { Outcome::Undecided } else { Outcome::BouncesThenSettles };
        assert_eq!(summary.outcome, expected, "{duration_s} s: {:?}", summary.verdict);
    }
}

/// A mass of 20 kg that is thrown off at 1 m/s against 20 N returns after 2 s. No energy is lost, so the
/// motion repeats.
#[test]
fn regress_a_tool_that_is_pushed_back_is_waited_for() {
    let body = "velocity = 1.0";
    for duration_s in [0.5, 0.9, 1.5] {
        let summary = outcome_of(
            body,
            "gap = 0.001",
            "kind = \"force\"",
            "kp = 0.0\nperiod = 1e-3\nreference = 20.0",
            duration_s,
        );
        assert!(
            summary.simulated_s > duration_s && summary.outcome != Outcome::NoContact,
            "{duration_s} s: {:?}",
            summary.verdict
        );
    }
}

/// By linear theory the loop is stable up to 1.18 times its gain. The motion due to sensor noise does not
/// grow, whatever its seed.
#[test]
fn regress_noise_on_a_stable_loop_near_its_limit_is_not_unstable() {
    let place = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"))
        .join("chatter/sustained.toml");
    let document = Document::load(&place).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    for seed in 1..9 {
        let settings = [
            ("contacts.tool.stiffness", 336_432.686_380_111_9),
            ("controllers.force.kp", 5.0 / 11.0),
            ("run.duration", 1.0),
            ("run.seed", f64::from(seed)),
        ];
        let settings = settings.map(|(key, value)| (key, feeler_files::Setting::Number(value)));
        let scenario = document.with(settings).unwrap_or_else(|mistakes| panic!("{mistakes}")).scenario;
        let summary = PreparedRun::new(scenario)
            .and_then(|candidate| candidate.measure(0))
            .unwrap_or_else(|error| panic!("{error}"))
            .summary;
        assert_eq!(summary.outcome, Outcome::BouncesThenSettles, "seed {seed}: {:?}", summary.verdict);
    }
}

/// With steps of 8 N no reading equals 20 N, so the integrator swings by 3.9 N without end. Steps of 0.2 N
/// keep the force within the settling band.
#[test]
fn regress_a_swing_within_the_steps_of_the_sensor_is_no_rest() {
    let place = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"))
        .join("why/sensor-quantiser.toml");
    let document = Document::load(&place).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    let outcome = |step: f64| {
        let settings = [("sensors.force.resolution", feeler_files::Setting::Number(step))];
        let scenario = document.with(settings).unwrap_or_else(|mistakes| panic!("{mistakes}")).scenario;
        PreparedRun::new(scenario)
            .and_then(|candidate| candidate.measure(0))
            .unwrap_or_else(|error| panic!("{error}"))
            .summary
            .outcome
    };
    assert_eq!((outcome(8.0), outcome(0.2)), (Outcome::Oscillates, Outcome::Settled));
}

/// Routh: `m s^3 + b s^2 + k (1 + kp) s + k ki` is stable up to `ki = b (1 + kp) / m = 30` 1/s. Far above
/// this, flights are so long that the longest run has only a few bounces.
#[test]
fn regress_few_bounces_that_grow_are_unstable() {
    let body = "[springs.guide]\nbetween = [\"ground\", \"m\"]\ndamping = 100\n\
                [sensors.encoder]\nreads = \"m.position\"";
    let outcome = |ki: f64| {
        let controller = format!(
            "kp = 0.5\nki = {ki}\nperiod = 1e-3\nreference = 20.0\n\
             approach = {{ speed = \"20 mm/s\", until = \"3 N\" }}"
        );
        outcome_of(body, "damping = 300\ngap = 0.002", "kind = \"force\"", &controller, 3.0)
    };
    assert_eq!(outcome(5.0).outcome, Outcome::Settled);
    for ki in [200.0, 400.0] {
        let summary = outcome(ki);
        assert_eq!(
            summary.outcome,
            Outcome::Unstable,
            "{ki}: {:?} after {} bounces",
            summary.verdict,
            summary.bounces
        );
    }
}

/// Two loops without contact. The first has a drive at its limit and an integrator without anti-windup. The
/// second controls a load behind free play.
#[test]
fn truth_loops_without_contact_are_judged_by_what_they_control() {
    let outcome = |text: &str| {
        let document = Document::parse(text, "loop.toml").unwrap();
        let summary = feeler_studies::run::run(&document.scenario, &mut |_| {}).unwrap().summary;
        assert!(summary.controlled.is_some());
        summary.outcome
    };
    // Each swing takes longer than the last: to the end of the run there are three to seven.
    for seconds in ["10.0", "15.0", "20.0", "30.0", "60.0", "100.0"] {
        let run = WINDUP.replace("duration = 10.0", &format!("duration = {seconds}"));
        assert_eq!(outcome(&run), Outcome::Unstable, "{seconds} s");
    }
    assert_eq!(outcome(PLAY), Outcome::LimitCycle);
    // The second loop settles without free play.
    assert_eq!(outcome(&PLAY.replace("[springs.s.effects.backlash]\nwidth = 0.001\n", "")), Outcome::Settled);
}

/// The heat at 30 N reduces the force by 12 % in the end; the command makes up for it.
#[test]
fn regress_a_drive_that_warms_winds_nothing_up() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/effects/thermal-derating.toml");
    let mut draft = Draft::load(Path::new(file)).unwrap();
    draft.set("actuators.drive.effects.thermal-derating.time_constant=1").unwrap();
    let document = draft.build().unwrap();
    let summary = feeler_studies::run::run(&document.scenario, &mut |_| {}).unwrap().summary;
    assert_eq!(summary.outcome, Outcome::Settled, "{:?}", summary.verdict);
}

/// Every scenario of an axis has a decided outcome within its own duration.
#[test]
fn prop_no_scenario_of_the_project_ends_undecided() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"));
    let mut undecided = Vec::new();
    for folder in
        ["chatter", "contact", "control", "effects", "limits", "paper", "reference", "surface", "why"]
    {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "toml") {
                continue;
            }
            let document = Document::load(&path).unwrap();
            let result = feeler_studies::run::run(&document.scenario, &mut |_| {}).unwrap();
            let summary = result.summary;
            if summary.outcome == Outcome::Undecided {
                undecided.push(format!("{}: {:?}", path.display(), summary.verdict));
            }
        }
    }
    assert!(undecided.is_empty(), "{}", undecided.join("\n"));
}

/// The settling band: 2 % of 20 N.
const SETTLED_N: f64 = 0.4;

/// Every scenario of a whole arm has a decided outcome. At low gain the arm settles at 20 N, and at high gain
/// it chatters. Thrown at the workpiece with idle drives, it does not return.
#[test]
fn prop_no_scenario_of_an_arm_ends_undecided() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/arms"));
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        // The description of the arm itself is not a scenario.
        let draft = Draft::load(&path).ok().filter(Draft::has_arm);
        if let Some(draft) = draft {
            let file = CellFile::build(draft).unwrap_or_else(|error| panic!("{error}"));
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            found.insert(name, run_cell(&file, &mut |_| {}).unwrap().summary);
        }
    }
    for (name, summary) in &found {
        assert_ne!(summary.figures.outcome, Outcome::Undecided, "{name}: {:?}", summary.figures.verdict);
    }
    let [low, high, impact] = ["press-low-gain", "press-high-gain", "impact"].map(|name| &found[name]);
    assert_eq!(low.figures.outcome, Outcome::Settled);
    assert!((low.final_force_n - 20.0).abs() < SETTLED_N, "{}", low.final_force_n);
    assert_eq!(high.figures.outcome, Outcome::Chatter);
    assert!(
        high.figures.bounces > 10 && high.figures.contact_share < 0.9,
        "{} {}",
        high.figures.bounces,
        high.figures.contact_share
    );
    assert_eq!((impact.figures.outcome, impact.figures.bounces), (Outcome::NoContact, 1));
}
