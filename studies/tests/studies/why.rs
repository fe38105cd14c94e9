//! `why` is right where the cause is known by construction. Each file of `why/` says in its header what was
//! added to a machine that settles without it.

#![expect(clippy::unwrap_used, reason = "a file that cannot be read or run fails the test that asks for it")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use feeler_files::{Document, Setting};
use feeler_studies::why::explain;

/// Scenarios of known cause that there must be at least, and of two causes among them.
const LEAST: (usize, usize) = (24, 3);

fn files() -> Vec<PathBuf> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join("why");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn known(path: &Path) -> BTreeSet<String> {
    let text = std::fs::read_to_string(path).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix("# Cause: ")).unwrap();
    line.split(", ").map(str::to_owned).collect()
}

#[test]
fn truth_the_cause_is_found_where_it_is_known() {
    let mut wrong = Vec::new();
    for path in files() {
        let found = explain(&Document::load(&path).unwrap().scenario, &|_| {}).unwrap();
        let causes: BTreeSet<String> = found
            .causes
            .iter()
            .map(|cause| serde_json::to_value(cause).unwrap().as_str().unwrap().to_owned())
            .collect();
        if causes != known(&path) {
            wrong.push(format!("{}: {causes:?}, not {:?}: {}", path.display(), known(&path), found.verdict));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn prop_there_are_enough_of_them() {
    let causes: Vec<BTreeSet<String>> = files().iter().map(|path| known(path)).collect();
    assert!(causes.len() >= LEAST.0);
    assert!(causes.iter().filter(|causes| causes.len() > 1).count() >= LEAST.1);
    assert_eq!(causes.into_iter().flatten().collect::<BTreeSet<_>>().len(), 9, "each cause is met");
}

/// A run that settles has nothing to explain, but a gain at which it would chatter: 0.9027 by the theory of
/// the same machine at another gain (`feeler analyze scenarios/chatter/sustained.toml`).
#[test]
fn truth_where_nothing_chatters_nothing_is_blamed() {
    let chatter = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/chatter"));
    let kp = |kp: f64| vec![("controllers.force.kp", Setting::Number(kp))];
    for (name, settings, limit) in [
        ("settles.toml", Vec::new(), "the loop is stable in contact up to 22 times its gain."),
        ("sustained.toml", kp(0.3), "kp = 0.3 is stable in contact up to 0.9027, 3 times as much."),
        ("sustained.toml", kp(0.6), "kp = 0.6 is stable in contact up to 0.9027, 50 % more."),
    ] {
        let document = Document::load(&chatter.join(name)).unwrap();
        let scenario = document.with(settings).unwrap().scenario;
        let found = explain(&scenario, &|_| {}).unwrap();
        assert!(!found.chatters && found.causes.is_empty(), "{}", found.verdict);
        assert!(found.verdict.starts_with(&format!("By linear theory {limit}")), "{}", found.verdict);
        assert!(found.verdict.contains("no chatter: the force settles"), "{}", found.verdict);
        // Each limit is that of the changed machine, in order.
        assert!(found.lifts.windows(2).all(|pair| pair[0].to.is_none() || pair[0].to >= pair[1].to));
        let named = format!("lift this limit most: {},", found.lifts[0].change.words());
        assert!(found.verdict.contains(&named), "{}", found.verdict);
    }
}

/// Closed form: with a zero-order hold proportional feedback destabilises an axis without damping at every
/// gain and period, and without the hold at none.
#[test]
fn regress_the_hold_is_named_where_no_gain_and_no_period_is_stable() {
    let document = Document::load(
        &Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join("paper/rigid.toml"),
    )
    .unwrap();
    let settings = [
        ("springs.guide.damping", 0.0),
        ("contacts.tool.damping", 0.0),
        ("controllers.force.kp", 0.3),
        ("run.duration", 4.0),
    ];
    let document = document.with(settings.map(|(key, value)| (key, Setting::Number(value)))).unwrap();
    let found = explain(&document.scenario, &|_| {}).unwrap();
    assert_eq!(
        found.causes.iter().map(|cause| cause.words()).collect::<Vec<_>>(),
        ["sampling and delay"],
        "{}",
        found.verdict
    );
    assert!(
        found.contributions[0].only_by_period && found.verdict.contains("unstable at every gain"),
        "{}",
        found.verdict
    );
    // With a drive of 30 Hz the growth does not come from the period.
    let mut late = document.scenario.clone();
    late.machine.actuators[0].kind =
        feeler_plant::description::ActuatorKind::Force { bandwidth_hz: Some(30.0) };
    let found = explain(&late, &|_| {}).unwrap();
    assert!(found.singles.iter().all(|trial| !trial.only_by_period), "{}", found.verdict);
}

/// k (1 + kp) = -k: no gain that is too high.
#[test]
fn regress_a_gain_below_zero_is_named_as_such() {
    let document = Document::load(
        &Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join("paper/rigid.toml"),
    )
    .unwrap();
    let document = document.with([("controllers.force.kp", Setting::Number(-2.0))]).unwrap();
    let found = explain(&document.scenario, &|_| {}).unwrap();
    assert!(
        found.wrong_sign && found.verdict.contains("wrong sign") && !found.verdict.contains("too high"),
        "{}",
        found.verdict
    );
    assert!(found.remedies.iter().any(|remedy| remedy.what.contains("other sign")), "{:?}", found.remedies);
}

/// The same machine with a tool that may leave: it is pushed off, and `no-contact` is not a rest.
#[test]
fn regress_a_gain_below_zero_is_named_where_the_tool_is_pushed_off() {
    let document = Document::load(
        &Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join("paper/rigid-contact.toml"),
    )
    .unwrap();
    let document = document.with([("controllers.force.kp", Setting::Number(-2.0))]).unwrap();
    let found = explain(&document.scenario, &|_| {}).unwrap();
    assert!(found.wrong_sign && found.verdict.contains("wrong sign"), "{}", found.verdict);
}

/// Without damping anywhere: with feedback the hold makes it grow, without it nothing takes energy out of the
/// bounces.
#[test]
fn regress_bouncing_that_nothing_damps_has_a_cause() {
    let document = Document::load(
        &Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join("paper/rigid-contact.toml"),
    )
    .unwrap();
    let found = |kp: f64| {
        let settings =
            [("springs.guide.damping", 0.0), ("contacts.tool.damping", 0.0), ("controllers.force.kp", kp)];
        explain(
            &document.with(settings.map(|(key, value)| (key, Setting::Number(value)))).unwrap().scenario,
            &|_| {},
        )
        .unwrap()
    };
    let held = found(0.5);
    assert_eq!(
        held.causes.iter().map(|cause| cause.words()).collect::<Vec<_>>(),
        ["sampling and delay"],
        "{}",
        held.verdict
    );
    let free = found(0.0);
    assert!(
        free.undamped && free.causes.is_empty() && free.verdict.contains("has no damping"),
        "{}",
        free.verdict
    );
}

/// A loop at 97 % of its limit that settles without noise: the noise is named before all that would move the
/// limit.
#[test]
fn regress_noise_is_told_from_what_it_excites() {
    let document = Document::load(
        &Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join("why/noise.toml"),
    )
    .unwrap();
    let found = explain(&document.scenario, &|_| {}).unwrap();
    assert!(
        found.linear_stable == Some(true) && found.verdict.contains("response to sensor noise"),
        "{}",
        found.verdict
    );
    let slower = found
        .singles
        .iter()
        .find(|trial| trial.changes == [feeler_studies::why::Counterfactual::SlowerApproach])
        .unwrap();
    assert!(!slower.cured);
}

/// A wall that only the controller makes: nothing touches, and `no-contact` is its rest. Passive up to 2 b /
/// T = 120 kN/m.
#[test]
fn regress_a_virtual_wall_that_grows_is_explained() {
    let document = Document::load(
        &Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join("control/virtual-wall.toml"),
    )
    .unwrap();
    let document = document.with([("controllers.wall.stiffness", Setting::Number(150e3))]).unwrap();
    let found = explain(&document.scenario, &|_| {}).unwrap();
    assert_eq!(
        found.causes.iter().map(|cause| cause.words()).collect::<Vec<_>>(),
        ["sampling and delay"],
        "{}",
        found.verdict
    );
    let margin = found.gain_margin.unwrap();
    assert!((margin - 0.8).abs() < 0.008, "{margin}");
    assert!(!found.remedies.is_empty());
}

/// The loop of a sampled servo in contact: 2 ms from sample to sample, and 2 ms until the output acts.
const SERVO: &str = r#"
[bodies.m]
mass = 2.0
[springs.guide]
between = ["ground", "m"]
damping = 5.0
[contacts.tool]
between = ["m", "ground"]
stiffness = 20000.0
damping = 20.0
gap = 0.002
[actuators.servo]
on = "m"
kind = "position-servo"
kp = 40000.0
kd = 100.0
period = 0.002
compute_delay = 0.002
[controllers.target]
law = "open-loop"
drives = "servo"
period = 0.001
reference = 0.003
[run]
duration = 1.0
"#;

#[test]
fn regress_a_sampled_servo_is_explained_as_the_same_loop_of_a_controller() {
    let controller = SERVO
        .replace(
            "kind = \"position-servo\"\nkp = 40000.0\nkd = 100.0\nperiod = 0.002\ncompute_delay = 0.002",
            "[sensors.encoder]\nreads = \"m.position\"",
        )
        .replace(
            "law = \"open-loop\"\ndrives = \"servo\"\nperiod = 0.001",
            "law = \"position\"\nreads = \"encoder\"\nmotion = \"encoder\"\ndrives = \"servo\"\n\
             kp = 40000.0\ndamping = 100.0\nperiod = 0.002\ndelay = 0.002",
        );
    let [servo, controller] = [SERVO, &controller].map(|text| {
        let document = Document::parse(text, "servo.toml").unwrap_or_else(|mistakes| panic!("{mistakes}"));
        explain(&document.scenario, &|_| {}).unwrap()
    });
    let of = |found: &feeler_studies::why::Explanation| {
        found.causes.iter().map(|cause| cause.words()).collect::<Vec<_>>()
    };
    assert_eq!(of(&controller), ["sampling and delay"], "{}", controller.verdict);
    assert_eq!(of(&servo), of(&controller), "{}", servo.verdict);
    assert!(!servo.remedies.is_empty() && servo.remedies.iter().all(|remedy| !remedy.settings.is_empty()));
    // One loop, so one limit; edges are exact to 1e-12.
    let [a, b] = [servo.gain_margin.unwrap(), controller.gain_margin.unwrap()];
    assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
}

/// A load behind 1 mm of free play, positioned by an integrator: it hunts across the play, and without play
/// it comes to rest. A rigid transmission would cure too, but has no mode that linear theory blames.
pub(crate) const PLAY: &str = r#"
[bodies.m]
mass = 2.0
[bodies.t]
mass = 2.0
[springs.g]
between = ["ground", "m"]
damping = 30.0
[springs.gt]
between = ["ground", "t"]
damping = 5.0
[springs.s]
between = ["m", "t"]
stiffness = 200000.0
damping = 40.0
[springs.s.effects.backlash]
width = 0.001
[actuators.drive]
on = "m"
[sensors.p]
reads = "t.position"
[sensors.vm]
reads = "m.velocity"
[controllers.c]
law = "position"
reads = "p"
motion = "vm"
drives = "drive"
period = 0.001
kp = 1500.0
ki = 3000.0
damping = 60.0
reference = 0.01
[run]
duration = 8.0
"#;

#[test]
fn truth_free_play_is_named_where_it_sustains_the_motion() {
    let explained = |text: &str| {
        let document = Document::parse(text, "play.toml").unwrap_or_else(|mistakes| panic!("{mistakes}"));
        explain(&document.scenario, &|_| {}).unwrap()
    };
    let found = explained(PLAY);
    assert_eq!(found.causes, [feeler_studies::why::ChatterCause::FreePlay], "{}", found.verdict);
    assert!(found.verdict.contains("motion") && !found.verdict.contains("contact"), "{}", found.verdict);
    // The unit of its amplitude follows from it.
    let judged = found.baseline.controlled.unwrap_or_default();
    assert!(judged.ends_with(".position"), "{judged}");
    let without = explained(&PLAY.replace("[springs.s.effects.backlash]\nwidth = 0.001\n", ""));
    assert!(!without.chatters && without.verdict.contains("comes to rest"), "{}", without.verdict);
}
