//! Tuned controllers: against brute force, and over uncertain machines.

#![expect(clippy::print_stdout, reason = "figures that a documentation quotes")]
#![expect(clippy::unwrap_used, reason = "a file that cannot be read or run fails the test that asks for it")]

use std::path::Path;

use feeler_analysis::{ClosedLoop, ControlLoop, MarginReport};
use feeler_engine::Scenario;
use feeler_files::{Document, Setting};
use feeler_problem::Remedy as _;
use feeler_studies::operating_point::contact_view;
use feeler_studies::run::{Outcome, PreparedRun, measure};
use feeler_studies::tune::{Spec, Tuned, Uncertain, machines, tune};
use rayon::prelude::*;

pub(crate) fn file(name: &str, settings: &[(&str, Setting)]) -> Document {
    let scenarios = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"));
    let document = Document::load(&scenarios.join(name)).and_then(|file| file.with(settings.iter().cloned()));
    document.unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

/// Promised share of the bandwidth that brute force finds.
const PROMISED: f64 = 0.95;

fn tuned(document: &Document, spec: &str) -> Tuned {
    let alone = [document.scenario.clone()];
    tune(document, &Spec::parse(spec).unwrap(), &alone, &|_| {}).unwrap_or_else(|error| panic!("{error}"))
}

fn with(document: &Document, settings: &[(String, f64)]) -> Scenario {
    document
        .with(settings.iter().map(|(key, value)| (key.as_str(), Setting::Number(*value))))
        .unwrap()
        .scenario
}

/// The bandwidth of a loop that keeps 45 degrees and 6 dB either way.
fn allowed_hz(scenario: &Scenario, controller: &str) -> Option<f64> {
    let whole = ControlLoop::new(scenario, &contact_view(scenario)).ok()?;
    let controller = whole.controller(controller).ok()?;
    let margins = MarginReport::new(&whole.open_loop(controller).ok()?.transfer().ok()?).ok()?;
    let keeps = margins.unstable_poles == 0
        && margins.phase_deg.is_none_or(|phase| phase.abs() >= 45.0)
        && margins.gain.is_none_or(|factor| factor >= 2.0)
        && margins.gain_decrease.is_none_or(|factor| factor <= 0.5);
    let bandwidth_hz = ClosedLoop::sampled(&whole, controller).ok()??.bandwidth_hz().ok()?;
    keeps.then(|| bandwidth_hz.unwrap_or(0.5 / whole.controllers()[controller].spec.period_s))
}

/// Whether a run comes to rest.
fn rests(scenario: Scenario) -> bool {
    let measured = PreparedRun::new(scenario).and_then(|candidate| candidate.measure(0));
    measured.is_ok_and(|measured| measured.summary.outcome.is_stable())
}

/// Whether a loop with some settings comes to rest, and so do each share of its gains in the order of trying,
/// and its neighbours. These have 5 % less and more of the gains, and of each frequency that is set.
fn rests_around(
    document: &Document,
    controller: &str,
    gains: &[&str],
    settings: &[(String, f64)],
) -> Result<(), String> {
    let key = |name: &str| format!("controllers.{controller}.{name}");
    let gains: Vec<String> = gains.iter().map(|name| key(name)).collect();
    let mut around: Vec<(&[String], f64)> =
        [1.0, 0.125, 0.25, 0.5, 0.75, 0.95, 1.05].map(|times| (gains.as_slice(), times)).to_vec();
    let frequencies =
        [vec![key("low_pass")], vec![key("notch.frequency")], vec![key("lead.zero"), key("lead.pole")]];
    for moved in frequencies.iter().filter(|of| settings.iter().any(|(key, _)| *key == of[0])) {
        around.extend([0.95, 1.05].map(|times| (moved.as_slice(), times)));
    }
    for (keys, times) in around {
        let moved: Vec<(String, f64)> = (settings.iter())
            .map(|(key, value)| (key.clone(), if keys.contains(key) { times * value } else { *value }))
            .collect();
        if !rests(with(document, &moved)) {
            return Err(format!("no rest at {moved:?}"));
        }
    }
    Ok(())
}

/// The settings of a tuned controller.
fn tuned_settings(tuned: &Tuned) -> Vec<(String, f64)> {
    let pairs = tuned.settings.iter().map(|words| words.split_once('=').unwrap());
    pairs.map(|(key, value)| (key.to_owned(), value.parse().unwrap())).collect()
}

/// Values from one to another, each by the same factor above the last.
fn spread([low, high]: [f64; 2], count: i32) -> Vec<f64> {
    (0..count).map(|i| low * (high / low).powf(f64::from(i) / f64::from(count - 1))).collect()
}

/// Points of brute force: factors on the gains on errors that the file has, each with each set of other
/// numbers.
struct Grid {
    tuned: &'static str,
    factors: Vec<f64>,
    others: Vec<Vec<(&'static str, f64)>>,
}

impl Grid {
    /// Six decades of gain.
    fn of_gains(count: i32) -> Self {
        Self { tuned: "gains", factors: spread([1e-3, 1e3], count), others: vec![Vec::new()] }
    }

    /// Gains, a fifteenth apart, and another number.
    fn with(tuned: &'static str, name: &'static str, range: [f64; 2]) -> Self {
        let others = spread(range, 60).into_iter().map(|value| vec![(name, value)]).collect();
        Self { tuned, factors: spread([0.02, 50.0], 120), others }
    }

    /// Gains, and a lead whose pole lies at most twelve times above its zero.
    fn with_lead() -> Self {
        let ratios = spread([1.5, 12.0], 6);
        let lead = |zero: f64, ratio: &f64| vec![("lead.zero", zero), ("lead.pole", zero * ratio)];
        let zeros = spread([2.0, 450.0], 40).into_iter();
        let others = zeros.flat_map(|zero| ratios.iter().map(move |ratio| lead(zero, ratio))).collect();
        Self { tuned: "gains and lead", factors: spread([0.02, 50.0], 80), others }
    }

    /// The largest allowed bandwidth that comes to rest with all around it.
    fn best_hz(&self, document: &Document, controller: &str, gains: &[&str]) -> f64 {
        let key = |name: &str| format!("controllers.{controller}.{name}");
        let numbers = document.numbers();
        let present = |name: &str| numbers.iter().find(|number| number.key == key(name)).unwrap().value;
        let mut points = Vec::new();
        for factor in &self.factors {
            for other in &self.others {
                let scaled = gains.iter().map(|name| (key(name), factor * present(name)));
                let beside = other.iter().map(|(name, value)| (key(name), *value));
                points.push(scaled.chain(beside).collect::<Vec<(String, f64)>>());
            }
        }
        let allowed = |settings: Vec<(String, f64)>| {
            allowed_hz(&with(document, &settings), controller).map(|hz| (hz, settings))
        };
        let mut found: Vec<_> = points.into_par_iter().filter_map(allowed).collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let is_safe =
            |settings: &[(String, f64)]| rests_around(document, controller, gains, settings).is_ok();
        found.into_iter().find(|(_, settings)| is_safe(settings)).map_or(0.0, |(hz, _)| hz)
    }
}

/// Tunes by a specification, and compares with brute force. Prints a row of a table.
fn compare(name: &str, spec: &str, grid: &Grid) {
    let document = file(name, &[]);
    let (controller, used) = document.scenario.controllers.first().unwrap();
    let gains: Vec<&str> = ["kp", "ki", "kd"]
        .into_iter()
        .filter(|gain| feeler_analysis::gain(&used.spec, gain).is_ok_and(|value| value != 0.0))
        .collect();
    let tuned = tuned(&document, spec);
    let brute_hz = grid.best_hz(&document, controller, &gains);
    assert!(brute_hz > 0.0, "{name}: brute force finds nothing");
    let ratio = tuned.bandwidth_hz / brute_hz;
    println!("| `{name}` | {} | {:.2} | {brute_hz:.2} | {ratio:.3} |", grid.tuned, tuned.bandwidth_hz);
    assert!(ratio >= PROMISED, "{name}: {} Hz, {brute_hz} Hz", tuned.bandwidth_hz);
    // The written gains have the promised bandwidth.
    let written = with(&document, &tuned_settings(&tuned));
    let hz = allowed_hz(&written, controller).unwrap();
    assert!((hz / tuned.bandwidth_hz - 1.0).abs() < 1e-9, "{name}: {hz} Hz written");
}

#[test]
fn prop_the_bandwidth_is_that_of_brute_force() {
    compare("paper/flexible-contact.toml", "", &Grid::of_gains(150));
    compare("control/lead.toml", "", &Grid::of_gains(150));
}

/// The paper's machines and twelve others, with damping where the file has some; damping by itself; a notch,
/// a low-pass and a lead: `cargo test -p feeler-studies --test studies tune -- --ignored --nocapture
/// --test-threads=1` prints the tables of `docs/tuning.md`.
#[test]
#[ignore = "takes minutes"]
fn prop_the_bandwidth_is_that_of_brute_force_everywhere() {
    println!("\n| scenario | tuned | `feeler tune`, Hz | brute force, Hz | ratio |\n|---|---|---|---|---|");
    for name in [
        "paper/rigid-contact.toml",
        "paper/flexible-contact.toml",
        "paper/workpiece-contact.toml",
        "paper/base-contact.toml",
        "paper/all-three-contact.toml",
        "chatter/sustained.toml",
        "chatter/bounces.toml",
        "control/lead.toml",
        "limits/sampled-delay.toml",
        "limits/noncolocated.toml",
        "limits/workpiece-lead.toml",
        "limits/integral-delay.toml",
        "reference/m2.toml",
    ] {
        compare(name, "", &Grid::of_gains(500));
    }
    // Without `gains`, damping is tuned where the file has some.
    let damping = Grid::with("gains and damping", "damping", [10.0, 2e4]);
    for name in
        ["control/windup.toml", "chatter/settles.toml", "contact/hard-wall.toml", "limits/base-dip.toml"]
    {
        compare(name, "", &damping);
    }
    for name in ["chatter/sustained.toml", "paper/flexible-contact.toml"] {
        compare(name, "gains = kp+damping", &damping);
    }
    let band = [2.0, 450.0];
    let notch = Grid::with("gains and notch", "notch.frequency", band);
    compare("chatter/sustained.toml", "structure = gains+notch", &notch);
    let filter = Grid::with("gains and low-pass", "low_pass", band);
    compare("paper/flexible-contact.toml", "structure = gains+filter", &filter);
    for name in ["paper/rigid-contact.toml", "chatter/sustained.toml"] {
        compare(name, "structure = gains+lead", &Grid::with_lead());
    }
}

/// By theory alone the best notch lies at the edge of chatter. A run settles at 20.45 Hz, and chatters at
/// 20.5 Hz, and at three quarters of the gain.
#[test]
fn regress_a_proposal_at_the_edge_of_chatter_is_refused() {
    let document = file("chatter/sustained.toml", &[("run.duration", Setting::Number(2.0))]);
    let at = |kp: f64, hz: f64| {
        let [gain, notch] = ["kp", "notch.frequency"].map(|name| format!("controllers.force.{name}"));
        rests_around(&document, "force", &["kp"], &[(gain, kp), (notch, hz)])
    };
    at(1.768, 20.45).unwrap_err();
    let tuned = tuned(&document, "structure = gains+notch");
    rests_around(&document, "force", &["kp"], &tuned_settings(&tuned)).unwrap();
    let shares: Vec<f64> = tuned.steps.iter().map(|step| step.share).collect();
    assert!(shares.windows(2).all(|pair| pair[1] <= 2.0 * pair[0]) && shares[0] <= 0.125, "{shares:?}");
    // Without a notch, 34 Hz; by theory alone with one, 66 Hz.
    assert!((50.0..66.0).contains(&tuned.bandwidth_hz), "{} Hz", tuned.bandwidth_hz);
}

/// A wall that is known within half and twice, and a delay.
fn uncertain() -> Vec<Uncertain> {
    let of = |key: &str, value: f64, interval| Uncertain { key: key.into(), value, interval };
    vec![
        of("contacts.tool.stiffness", 2e5, [1e5, 4e5]),
        of("controllers.force.delay", 0.4e-3, [0.2e-3, 0.8e-3]),
    ]
}

/// The same numbers with a guide of unknown friction.
fn with_friction() -> Vec<Uncertain> {
    let key = "springs.guide.effects.coulomb-friction.level".to_owned();
    let mut all = uncertain();
    all.insert(1, Uncertain { key, value: 3.0, interval: [0.0, 6.0] });
    all
}

/// Tuned on some draws, it comes to rest on those and on as many others of the same intervals. Prints a row
/// of a table.
fn over_draws(name: &str, settings: &[(&str, Setting)], uncertain: &[Uncertain], draws: usize) {
    let document = file(name, settings);
    let drawn = machines(&document, uncertain, draws, 0).unwrap();
    let tuned = tune(&document, &Spec::default(), &drawn, &|_| {}).unwrap();
    assert_eq!(tuned.machines, draws + 1);
    assert_eq!(tuned.runs.outcomes.values().sum::<usize>(), draws + 1);
    let rests = |name: &str| Outcome::ALL.iter().any(|(outcome, own)| *own == name && outcome.is_stable());
    assert!(tuned.runs.outcomes.keys().all(|name| rests(name)), "{:?}", tuned.runs.outcomes);
    let settings = tuned_settings(&tuned);
    let set =
        document.with(settings.iter().map(|(key, value)| (key.as_str(), Setting::Number(*value)))).unwrap();
    let fresh = machines(&set, uncertain, draws, 1 << 16).unwrap();
    let candidates: Vec<PreparedRun> = fresh.into_iter().map(|one| PreparedRun::new(one).unwrap()).collect();
    let mut chatters = 0;
    for measured in measure(&candidates, 0) {
        let outcome = measured.unwrap().summary.outcome;
        chatters += usize::from(!outcome.is_stable());
    }
    println!("| `{name}` | {draws} | {:.2} | {chatters} |", tuned.bandwidth_hz);
    assert_eq!(chatters, 0);
}

/// The joint damping with which a tool that chatters may be tuned.
const DAMPED: [(&str, Setting); 1] = [("controllers.force.damping", Setting::Number(300.0))];

#[test]
fn prop_no_draw_of_an_uncertain_machine_chatters() {
    over_draws("chatter/sustained.toml", &DAMPED, &with_friction(), 7);
}

/// Run with the comparison above.
#[test]
#[ignore = "takes minutes"]
fn prop_none_of_200_draws_of_an_uncertain_machine_chatters() {
    println!("\n| scenario | draws | bandwidth, Hz | of as many others chatter |\n|---|---|---|---|");
    over_draws("chatter/sustained.toml", &DAMPED, &with_friction(), 200);
    over_draws("paper/flexible-contact.toml", &[], &uncertain(), 200);
}

#[test]
fn truth_steps_begin_low_and_each_says_when_to_stop() {
    let tuned = tuned(&file("paper/flexible-contact.toml", &[("run.duration", Setting::Number(1.0))]), "");
    let shares: Vec<f64> = tuned.steps.iter().map(|step| step.share).collect();
    assert_eq!(shares, [0.125, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(tuned.steps[4].settings, tuned.settings);
    for step in &tuned.steps {
        assert!(step.stop_force_n > step.expected.peak_force_n && step.swing_hz > 0.0);
        assert!(step.gain_margin.is_none_or(|factor| factor >= 2.0));
    }
}

/// The guide sticks and keeps the force off its reference, but at rest: there is a time to wait for that.
#[test]
fn regress_a_force_that_friction_keeps_off_its_reference_has_a_time_to_wait() {
    let tuned = tuned(&file("why/stiction-strong.toml", &[]), "");
    assert_eq!(tuned.runs.settling_time_s, None);
    let rests_s = tuned.runs.rest_time_s.unwrap();
    assert!((0.0..1.0).contains(&rests_s), "{rests_s}");
    assert!(tuned.steps.iter().all(|step| step.wait_s.is_some()), "{:?}", tuned.steps);
}

#[test]
fn truth_what_cannot_be_met_is_refused_with_a_way_out() {
    let document = file("paper/flexible-contact.toml", &[("run.duration", Setting::Number(1.0))]);
    let alone = [document.scenario.clone()];
    for (spec, what, remedy) in [
        ("peak force <= 1 N", " N, and 1 N is allowed", "slow the approach"),
        ("phase margin >= 179 deg, gain margin >= 200 dB", "no gains meet", "lower a limit"),
        ("gains = kq", "no gain `kq`", "name one of kp"),
        ("kq <= 5 N", "no gain `kq`", "name one of kp"),
        ("gains = kp+damping, damping <= 5 kg", "controllers.force.damping", "N s/m"),
        ("gains =", "names none", "name some of"),
        ("kp >= 5", "not tuned by itself", "gains = kp"),
        ("controller = arm", "no controller `arm`", "force"),
    ] {
        let error = tune(&document, &Spec::parse(spec).unwrap(), &alone, &|_| {}).unwrap_err();
        assert!(error.to_string().contains(what) && error.remedy().contains(remedy), "{spec}: {error}");
    }
}
