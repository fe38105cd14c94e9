//! Excessive requests, and files that are not valid texts.

use std::time::{Duration, Instant};

use feeler_files::{DatasetFile, Document, Draft, SweepFile, TEMPLATES};
use proptest::prelude::*;

use crate::COMPLETE;

/// Largest time of a report. It is a thousand times the usual time, so only a hang fails.
const HANG: Duration = Duration::from_secs(20);

#[expect(clippy::unwrap_used, reason = "without a refusal the test has failed")]
fn refused(assignments: &[&str]) -> String {
    let mut draft = Draft::parse(COMPLETE, "complete.toml").unwrap();
    for assignment in assignments {
        draft.set(assignment).unwrap();
    }
    draft.build().unwrap_err().to_string()
}

#[test]
fn truth_a_record_beyond_reason_is_refused_with_the_arithmetic() {
    let report = refused(&["run.duration=1e5", "run.record_rate=10 kHz"]);
    assert!(
        report.contains("100000 s * 10000 Hz = 1.000e9 rows of 3 signals = 3.000e9 numbers (24.0 GB)"),
        "{report}"
    );
    let report = refused(&["run.duration=0.01", "run.record_rate=1e6 kHz"]);
    assert!(report.contains("a row every 1e-9 s, and at most 1e8 rows a second"), "{report}");
}

#[test]
fn truth_steps_beyond_reason_are_refused_with_the_arithmetic() {
    let report =
        refused(&["run.duration=1e4", "run.record_rate=1 Hz", "run.integrator=rk4", "run.step=10 us"]);
    assert!(report.contains("10000 s / 1e-5 s = 1.000e9 steps"), "{report}");
    let mut exact = Draft::parse(COMPLETE, "complete.toml").unwrap();
    for assignment in ["run.duration=1e4", "run.record_rate=1 Hz", "run.step=10 us"] {
        exact.set(assignment).unwrap();
    }
    assert!(exact.build().is_ok(), "the exact integrator takes no such steps");
}

#[test]
fn truth_work_beyond_reason_is_refused_with_the_arithmetic() {
    let report = refused(&["run.duration=100", "run.record_rate=1 Hz", "controllers.force.period=1e-8"]);
    assert!(
        report.contains("controllers.force.period: 100 s / 1e-8 s") && report.contains("1.000e10 samples"),
        "{report}"
    );
    let report = refused(&["run.duration=1e7", "run.record_rate=1 Hz"]);
    assert!(
        report.contains("run.duration: 1e7 s / 0.001 s")
            && report.contains("1.000e10 samples, and at most 2e8"),
        "{report}"
    );
    let report =
        refused(&["contacts.tool.law=kelvin-voigt", "contacts.tool.stiffness=1e15", "bodies.tip.mass=1e-6"]);
    assert!(report.contains("sqrt(1e15 N/m / 1e-6 kg) / 2 pi = 5.033e9 Hz"), "{report}");
    let chain = (0..400).map(|i| format!("[bodies.b{i}]\nmass = 1.0\n")).collect::<Vec<_>>().concat();
    let report = Document::parse(&chain, "chain.toml").unwrap_err().to_string();
    assert!(report.contains("there are 400 bodies, and at most 256"), "{report}");
}

#[test]
fn regress_a_folder_is_no_file() {
    let report = Document::load(env!("CARGO_MANIFEST_DIR").as_ref()).unwrap_err().to_string();
    assert!(report.contains("this is a folder"), "{report}");
}

#[test]
fn truth_numbers_that_nobody_can_mean_are_refused_in_short() {
    for setting in [
        "bodies.tip.mass=1e-300",
        "bodies.tip.mass=1e300",
        "controllers.force.period=1e-12",
        "controllers.force.delay=1e9",
        "sensors.force.delay=1e9",
        "run.record_rate=1e-3",
    ] {
        let report = refused(&[setting]);
        let longest = report.lines().map(str::len).max().unwrap_or(0);
        assert!(longest < 200 && report.contains("help"), "{setting}: {report}");
    }
}

#[test]
fn regress_deep_nesting_is_refused_and_not_followed() {
    for text in [
        "[".repeat(200_000),
        "a.".repeat(200_000),
        "a={".repeat(100_000),
        format!("a = {}", "[".repeat(100_000)),
    ] {
        let start = Instant::now();
        assert!(Document::parse(&text, "deep.toml").is_err());
        assert!(start.elapsed() < HANG);
    }
}

#[test]
fn regress_many_mistakes_make_a_bounded_report() {
    let bodies: Vec<String> = (0..20_000).map(|i| format!("[bodies.b{i}]\nmass = -1.0\n")).collect();
    let text = bodies.concat();
    let start = Instant::now();
    let error = Document::parse(&text, "many.toml").unwrap_err();
    assert_eq!((error.problems.len(), error.problems.len() + error.omitted), (1000, 20_001));
    // One mistake for each mass, and one for the number of bodies.
    let report = error.report(false);
    assert!(report.len() < 20_000, "a report shows the first problems and counts the rest");
    assert!(report.contains("and 19951 more") && report.ends_with("20001 mistakes"), "{report}");
    assert!(start.elapsed() < HANG);
}

fn mutated() -> impl Strategy<Value = String> {
    let texts: Vec<&'static str> = TEMPLATES.iter().map(|template| template.text).chain([COMPLETE]).collect();
    let pieces = prop::sample::select(vec![
        "[",
        "]",
        "=",
        "\"",
        "\n",
        "{",
        "}",
        ",",
        ".",
        "-",
        "nan",
        "inf",
        "1e999",
        "ground",
        "\u{0}",
        "'''",
        "ä",
        "N/m^",
        "9999999999999999999999",
        "[run]\n",
        "effects",
        "# ",
        "true",
        "[[",
        "1979-05-27",
    ]);
    (
        prop::sample::select(texts),
        prop::collection::vec((any::<prop::sample::Index>(), 0..40_usize, pieces), 1..6),
    )
        .prop_map(|(text, edits)| {
            let mut characters: Vec<char> = text.chars().collect();
            for (at, removed, piece) in edits {
                let start = at.index(characters.len() + 1);
                let end = (start + removed).min(characters.len());
                characters.splice(start..end, piece.chars());
            }
            characters.into_iter().collect()
        })
}

/// Work of an accepted scenario: the sum of samples, cycles of the stiffest spring, and rows.
fn work(document: &Document) -> f64 {
    let run = &document.scenario.run;
    let machine = &document.scenario.machine;
    let samples: f64 =
        document.scenario.controllers.values().map(|used| run.duration_s / used.spec.period_s).sum();
    let mass = machine.bodies.values().map(|body| body.mass_kg).fold(f64::INFINITY, f64::min);
    let stiffness = machine.springs.values().map(|spring| spring.stiffness_n_per_m).fold(0.0, f64::max);
    let rows = run.duration_s * run.record_rate_hz.unwrap_or(1.0 / run.step_s);
    samples + rows + run.duration_s * (stiffness / mass).sqrt() / std::f64::consts::TAU
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn prop_extreme_numbers_are_refused_or_bounded_work(
        exponents in prop::collection::vec(-320..310_i32, 5),
        negative in any::<bool>(),
    ) {
        let mut draft = Draft::parse(COMPLETE, "complete.toml").unwrap();
        let keys = [
            "controllers.force.period",
            "controllers.force.delay",
            "sensors.force.delay",
            "bodies.tip.mass",
            "run.duration",
        ];
        for (key, exponent) in keys.iter().zip(&exponents) {
            let sign = if negative { "-" } else { "" };
            draft.set(&format!("{key}={sign}1e{exponent}")).unwrap();
        }
        match draft.build() {
            // The sum of three budgets: samples, cycles, rows.
            Ok(document) => prop_assert!(work(&document) <= 2e8 + 1e8 + 1e8),
            Err(error) => prop_assert!(error.problems.iter().all(|problem| !problem.remedy.is_empty())),
        }
    }

    #[test]
    fn prop_a_mutilated_file_gives_a_scenario_or_a_report(text in mutated()) {
        match Document::parse(&text, "mutated.toml") {
            Ok(document) => prop_assert!(!document.to_toml().is_empty()),
            Err(error) => {
                prop_assert!(!error.problems.is_empty());
                prop_assert!(
                    error.problems.iter().all(|problem| problem.line > 0 && problem.span.end <= text.len())
                );
                prop_assert!(!error.report(true).is_empty());
            }
        }
    }

    #[test]
    fn prop_random_text_never_panics(
        text in any::<String>(),
        bytes in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        for text in [text, String::from_utf8_lossy(&bytes).into_owned()] {
            let _ = Document::parse(&text, "random.toml").map_err(|error| error.report(false));
            let _ = SweepFile::parse(&text, "random.toml").map_err(|error| error.report(false));
            let _ = DatasetFile::parse(&text, "random.toml").map_err(|error| error.report(false));
            let mut draft = Draft::parse(COMPLETE, "complete.toml").unwrap();
            let _ = draft.set(&text).and_then(|()| draft.build()).map_err(|error| error.report(false));
        }
    }

    #[test]
    fn prop_any_unit_text_is_a_number_or_a_mistake(text in "[0-9.e+-]{0,6} ?[a-zµ°%/^*() 0-9.-]{0,12}") {
        let file = format!("[bodies.m]\nmass = '{text}'\n");
        if let Ok(document) = Document::parse(&file, "unit.toml") {
            prop_assert!(document.scenario.machine.bodies["m"].mass_kg > 0.0);
        }
    }
}
