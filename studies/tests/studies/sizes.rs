//! How large a change `why` finds: far from the present size, in long runs, and below every size tried.

#![expect(clippy::unwrap_used, reason = "a file that cannot be read or run fails the test that asks for it")]

use feeler_files::Document;
use feeler_studies::run::{Outcome, run};
use feeler_studies::why::{ChatterCause, CheckedRemedy, Counterfactual, Explanation, explain};

use crate::remedies::{APPROACH, WINDUP, with_sensor};

fn explained(text: &str) -> Explanation {
    explain(&Document::parse(text, "loop.toml").unwrap().scenario, &|_| {}).unwrap()
}

/// How a plain run ends with these settings.
fn outcome(text: &str, settings: &[String]) -> Outcome {
    let written = Document::parse(text, "loop.toml").unwrap().with_settings(settings, None).unwrap();
    run(&Document::parse(&written, "loop.toml").unwrap().scenario, &mut |_| {}).unwrap().summary.outcome
}

fn remedy<'a>(found: &'a Explanation, words: &str) -> &'a CheckedRemedy {
    found.remedies.iter().find(|remedy| remedy.what.contains(words)).unwrap_or_else(|| panic!("{found:#?}"))
}

/// The number of a setting.
fn number(settings: &[String], key: &str) -> f64 {
    settings.iter().find_map(|set| set.strip_prefix(&format!("{key}="))?.parse().ok()).unwrap()
}

/// The search ends at a fifth of the size: at a milder one beyond that the motion goes on.
const BEYOND: f64 = 1.25;

/// The verdict names the limit, and both remedies work: a drive that is strong enough, and an integral that
/// knows what the drive can do.
#[test]
fn truth_a_loop_that_winds_up_has_a_limit_and_remedies() {
    let found = explained(WINDUP);
    assert_eq!(found.causes, [ChatterCause::Saturation], "{}", found.verdict);
    assert!(found.verdict.contains("saturation") && found.verdict.contains("limits "), "{}", found.verdict);
    for words in ["limits ", "an integral that stops at the drive's limit"] {
        let settings = &remedy(&found, words).settings;
        assert!(outcome(WINDUP, settings).is_stable(), "{settings:?}");
    }
    let limit = number(&remedy(&found, "limits ").settings, "actuators.drive.limit");
    let weaker = format!("actuators.drive.limit={}", limit / BEYOND);
    assert!(!outcome(WINDUP, &[weaker]).is_stable());
}

/// Ten times as strong a loop needs a limit beyond the first four sizes.
#[test]
fn truth_a_limit_far_too_low_is_found() {
    let strong = WINDUP.replace("kp = 1500.0", "kp = 15000.0").replace("ki = 9000.0", "ki = 90000.0");
    let found = explained(&strong);
    let size = found.sizes.iter().find(|size| size.of == Counterfactual::NoSaturation).unwrap();
    assert!(size.times > 64.0, "{size:?}");
    assert!(outcome(&strong, &size.settings).is_stable(), "{size:?}");
}

/// An approach at 3 m/s, and a reading half a second late: hundreds of times too much. And a long run.
#[test]
fn truth_a_size_is_found_however_far_and_however_long_the_run() {
    let fast = APPROACH.replace("speed = 0.3", "speed = 3.0");
    let late = with_sensor("delay = 0.5", 0.001, 1.2);
    let long = APPROACH.replace("duration = 3.0", "duration = 60.0");
    let [speed, delay] = ["controllers.f.approach.speed", "sensors.force.delay"];
    for (text, of, key, from, least) in [
        (&fast, Counterfactual::SlowerApproach, speed, 3.0, 64.0),
        (&late, Counterfactual::NoDelay, delay, 0.5, 64.0),
        (&long, Counterfactual::SlowerApproach, speed, 0.3, 1.5),
    ] {
        let found = explained(text);
        let size = found.sizes.iter().find(|size| size.of == of).unwrap_or_else(|| panic!("{found:#?}"));
        assert!(size.times > least, "{size:?}");
        assert!((number(&size.settings, key) * size.times / from - 1.0).abs() < 1e-3, "{size:?}");
        assert!(outcome(text, &size.settings).is_stable(), "{size:?}");
        assert!(found.verdict.contains(&size.what), "{}", found.verdict);
    }
}

/// A loop without damping grows slowly by its period alone: the mildest share of damping is below the first
/// one tried, of 3 %.
#[test]
fn regress_the_mildest_damping_is_not_above_the_first_share() {
    let bare = with_sensor("", 0.001, 0.5).replace("damping = 60.0", "damping = 0.0");
    let bare = bare.replace("damping = 120.0", "damping = 0.0");
    let found = explained(&bare);
    let settings = &remedy(&found, "joint damping").settings;
    let critical = 2.0 * (6.0_f64 * 100_000.0).sqrt();
    let share = number(settings, "controllers.f.damping") / critical;
    assert!(share < 0.04, "{share} {settings:?}");
    assert!(outcome(&bare, settings).is_stable(), "{settings:?}");
}

/// A drive whose force changes by at most 200 N/s. Linear theory knows no limit of the gain of this loop.
const SLEWS: &str = r#"
[bodies.m]
mass = 4.0
position = 0.5
[springs.g]
between = ["ground", "m"]
damping = 0.5
[actuators.drive]
on = "m"
rate_limit = 200.0
[sensors.enc]
reads = "m.position"
[controllers.c]
law = "position"
reads = "enc"
motion = "enc"
drives = "drive"
period = 0.002
kp = 1500.0
damping = 60.0
reference = 0.0
[run]
duration = 10.0
"#;

#[test]
fn truth_a_gain_is_searched_where_linear_theory_allows_it() {
    let found = explained(SLEWS);
    assert_eq!(found.linear_stable, Some(true), "{}", found.verdict);
    let lower = remedy(&found, "a lower gain");
    assert!(lower.gain_factor < 0.5 && lower.settles, "{lower:?}");
    assert!(outcome(SLEWS, &lower.settings).is_stable(), "{lower:?}");
}
