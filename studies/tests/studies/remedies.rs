//! Sizes, limits and settings of the remedies of `why`.

#![expect(clippy::unwrap_used, reason = "a file that cannot be read or run fails the test that asks for it")]

use feeler_analysis::{ControlLoop, View};
use feeler_files::Document;
use feeler_studies::why::{ChatterCause, Counterfactual, Explanation, explain};

use crate::common::file;

/// A mass before a stiff wall with hardly any damping: at 0.3 m/s it chatters, at 0.03 it settles.
pub(crate) const APPROACH: &str = r#"
[bodies.m]
mass = 8.0
[springs.g]
between = ["ground", "m"]
damping = 2.0
[contacts.tool]
between = ["m", "ground"]
stiffness = 400000.0
damping = 20.0
gap = 0.002
[actuators.drive]
on = "m"
[sensors.force]
reads = "tool.spring_force"
[sensors.enc]
reads = "m.position"
[controllers.f]
law = "explicit-force"
reads = "force"
drives = "drive"
motion = "enc"
period = 0.001
feed_forward = 1.0
kp = 0.05
reference = 20.0
approach = { speed = 0.3, until = 2.0, release = 1.0 }
[run]
duration = 3.0
"#;

/// A force loop with a filter or a delay at its sensor.
pub(crate) fn with_sensor(sensor: &str, period: f64, kp: f64) -> String {
    format!(
        r#"# A loop that a slow sensor spoils.
[bodies.m]
mass = 6.0
[springs.g]
between = ["ground", "m"]
damping = 60.0
[contacts.tool]
between = ["m", "ground"]
stiffness = 100000.0
damping = 120.0
gap = 0.001
[actuators.drive]
on = "m"
[sensors.force]
reads = "tool.spring_force"
{sensor}   # as bought
[sensors.enc]
reads = "m.position"
[controllers.f]
law = "explicit-force"
reads = "force"
drives = "drive"
motion = "enc"
period = {period}
feed_forward = 1.0
kp = {kp}
reference = 20.0
[run]
duration = 3.0
"#
    )
}

/// A drive at its limit, and an integral that winds up: 28 m after 10 s.
pub(crate) const WINDUP: &str = r#"
[bodies.m]
mass = 4.0
position = 0.5
[springs.g]
between = ["ground", "m"]
damping = 0.5
[actuators.drive]
on = "m"
limit = 20.0
[sensors.enc]
reads = "m.position"
[controllers.c]
law = "position"
reads = "enc"
drives = "drive"
period = 0.002
kp = 1500.0
ki = 9000.0
kd = 60.0
derivative_filter = 0.002
reference = 0.0
anti_windup = "off"
[run]
duration = 10.0
"#;

fn document(text: &str) -> Document {
    Document::parse(text, "loop.toml").unwrap()
}

fn explained(text: &str) -> Explanation {
    explain(&document(text).scenario, &|_| {}).unwrap()
}

#[test]
fn truth_the_approach_is_slowed_down_as_far_as_it_takes() {
    let found = explained(APPROACH);
    assert_eq!(found.causes, [ChatterCause::LossOfContact], "{}", found.verdict);
    let slower =
        found.singles.iter().find(|trial| trial.changes == [Counterfactual::SlowerApproach]).unwrap();
    assert!(slower.cured);
    let size = found.sizes.iter().find(|size| size.of == Counterfactual::SlowerApproach).unwrap();
    assert!((1.5..16.1).contains(&size.times), "{size:?}");
    let speed = size.settings.iter().find_map(|set| set.strip_prefix("controllers.f.approach.speed="));
    let speed: f64 = speed.unwrap().parse().unwrap();
    assert!((speed - 0.3 / size.times).abs() < 1e-3 * speed, "{size:?}");
    assert!(found.verdict.contains(&size.what), "{}", found.verdict);
}

/// An 8 Hz filter: without it the limit rises from 1.2 to 30 times the gain.
#[test]
fn truth_what_lifts_the_limit_twentyfold_stands_beside_the_verdict() {
    let found = explained(&with_sensor("low_pass = 8.0", 0.0002, 0.6));
    let named = found.smallest[0] == [Counterfactual::NoDelay];
    let lift = found.lift.as_ref().filter(|lift| lift.change == Counterfactual::NoDelay);
    assert!(named || lift.is_some_and(|lift| lift.to.is_none_or(|to| to > 20.0 * lift.from)), "{found:?}");
    assert!(found.verdict.contains("no delay"), "{}", found.verdict);
}

/// One gain is the whole law except for feed-forward, so its limit and the factor on it are one number.
#[test]
fn regress_why_and_analyze_agree_on_the_limit() {
    /// Edges are exact to 1e-12.
    const SAME: f64 = 1e-9;
    let document = document(&with_sensor("delay = 0.006", 0.001, 0.4));
    let found = explain(&document.scenario, &|_| {}).unwrap();
    let whole = ControlLoop::new(&document.scenario, &View::default()).unwrap();
    let limit = whole.sampled_bands("controllers.f.kp").unwrap().first_upper();
    let factor = found.gain_margin.unwrap();
    assert!((0.4 * factor - limit).abs() < SAME * limit, "{} {limit}", 0.4 * factor);
}

/// The written remedy equals the tried one, and comes to rest within the run of the written file. The verdict
/// states the limit as a value of the gain: 0.9027, as `feeler analyze` does.
#[test]
fn truth_remedies_are_settings_that_cure() {
    let delayed = with_sensor("delay = 0.006", 0.001, 1.2);
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"));
    let chatters = std::fs::read_to_string(folder.join("chatter/sustained.toml")).unwrap();
    for (text, comment, told) in [
        (delayed, "# as bought", "kp = 1.2 is"),
        (chatters, "# no stiffness: a viscous guide", "kp = 1.2 is 33 % above the limit of 0.9027"),
    ] {
        let found = explained(&text);
        assert!(found.verdict.contains(told), "{}", found.verdict);
        assert!(found.remedies.len() > 2, "{found:?}");
        for remedy in &found.remedies {
            assert!(remedy.settles && !remedy.settings.is_empty(), "{remedy:?}");
            let written = document(&text).with_settings(&remedy.settings, None).unwrap();
            assert!(written.contains(comment));
            let result = feeler_studies::run::run(&document(&written).scenario, &mut |_| {}).unwrap();
            let verdict = result.summary.verdict;
            assert!(verdict.outcome.is_stable(), "{remedy:?}: {verdict:?}");
        }
        let lead = found.remedies.iter().find(|remedy| remedy.what.starts_with("a lead with its zero at "));
        let frequencies = lead.map(|lead| lead.what.matches(" Hz").count());
        assert_eq!(frequencies, Some(2), "{:?}", found.remedies);
    }
}

/// Half a second shows that the loop chatters; with a lower gain it comes to rest only later. So the remedy
/// makes the run longer, and the text says how long.
#[test]
fn truth_a_remedy_that_rests_later_brings_a_longer_run() {
    let text = with_sensor("delay = 0.006", 0.001, 1.2).replace("duration = 3.0", "duration = 0.5");
    let found = explained(&text);
    assert!(!found.remedies.is_empty(), "{}", found.verdict);
    let mut longer = 0;
    for remedy in &found.remedies {
        let written = document(&text).with_settings(&remedy.settings, None).unwrap();
        let result = feeler_studies::run::run(&document(&written).scenario, &mut |_| {}).unwrap();
        assert!(result.summary.outcome.is_stable(), "{remedy:?}: {:?}", result.summary.verdict);
        let lengthens = remedy.settings.iter().any(|set| set.starts_with("run.duration="));
        assert_eq!(lengthens, remedy.what.contains(", over "), "{remedy:?}");
        longer += usize::from(lengthens);
    }
    assert!(longer > 0, "{:?}", found.remedies);
}

/// Without a delay none can be shortened, and without a motion sensor nothing can be damped. Such a remedy
/// would only be a lower gain under another name.
#[test]
fn truth_every_remedy_changes_something_of_its_own() {
    for name in ["why/hold.toml", "why/loss.toml", "why/noise.toml"] {
        let found = explain(&file(name, &[]).scenario, &|_| {}).unwrap();
        let settings: Vec<_> = found.remedies.iter().map(|remedy| &remedy.settings).collect();
        assert!(!settings.is_empty(), "{name}");
        for (i, own) in settings.iter().enumerate() {
            assert!(!settings[..i].contains(own), "{name}: {own:?}");
        }
    }
}
