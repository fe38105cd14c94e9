//! `feeler diagnose`, `feeler replay` and `feeler blind`, on records from `feeler run`.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::bench::{BAD_INPUT, Bench, DONE, exists};

/// An axis with a drive and a guide, without friction.
pub(crate) const AXIS: &str = r#"
name = "axis"
[bodies.tip]
mass = 5.0
[springs.guide]
between = ["ground", "tip"]
damping = 60.0
[actuators.drive]
on = "tip"
reacts_on = "ground"
kind = "force"
[sensors.encoder]
reads = "tip.position"
noise = 1.0e-7
[sensors.accelerometer]
reads = "tip.acceleration"
noise = 0.01
"#;
/// Dry friction of the real axis, N.
const LEVEL_N: f64 = 4.0;
/// Tolerance of the friction level: far above the effect of noise, and below what an engineer accepts.
const RIGHT: f64 = 0.03;
const COLUMNS: &str = r#"
name = "records"
machine = "machine.toml"
[columns."drive.command"]
signal = "drive.command"
hold = "1 ms"
[columns."encoder.reading"]
signal = "encoder.reading"
[columns."accelerometer.reading"]
signal = "accelerometer.reading"
"#;

/// A folder `cases/records` with three experiments on an axis that sticks.
pub(crate) fn records() -> Bench {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("cases/records")).unwrap();
    bench.write("cases/records/machine.toml", AXIS);
    let mut dataset = COLUMNS.to_owned();
    for (i, (level, role)) in [(6.0, "fit"), (15.0, "fit"), (10.0, "check")].into_iter().enumerate() {
        let scenario = format!(
            "{AXIS}[springs.guide.effects.coulomb-friction]\nlevel = {LEVEL_N}\n\
             [controllers.excitation]\nlaw = \"open-loop\"\ndrives = \"drive\"\nperiod = \"1 ms\"\n\
             reference = {{ kind = \"multisine\", rms = {level}, band = [1, 60], period = \"1 s\" }}\n\
             [run]\nduration = \"1.6 s\"\nrecord_rate = \"1 kHz\"\nseed = {i}\n\
             record = [\"drive.command\", \"encoder.reading\", \"accelerometer.reading\"]\n"
        );
        bench.write("real.toml", &scenario);
        let said = bench.feeler(&["run", "real.toml", "--csv", "--out", "real"]);
        assert_eq!(said.code, DONE, "{}", said.err);
        bench.write(&format!("cases/records/{i}.csv"), &bench.read("real/trace.csv"));
        let _ = write!(dataset, "[[experiments]]\nfile = \"{i}.csv\"\nrole = \"{role}\"\n");
    }
    bench.write("cases/records/dataset.toml", &dataset);
    bench
}

#[test]
fn truth_what_sticks_is_found_and_the_answer_is_used_at_once() {
    let bench = records();
    let believed = AXIS.replace("mass = 5.0", "mass = 5.0 # weighed");
    bench.write("cases/records/machine.toml", &believed);
    let said = bench.feeler(&["diagnose", "cases/records", "--out", "answer", "--changes", "--apply"]);
    assert_eq!(said.code, DONE, "{}", said.err);
    is_applied(&bench, &believed, &said.out);
    assert!(
        said.out.starts_with("records: ")
            && said.out.lines().next().unwrap().contains("coulomb-friction on springs.guide"),
        "{}",
        said.out
    );
    assert!(said.out.contains("[springs.guide.effects.coulomb-friction]"), "{}", said.out);
    assert!(said.out.contains("\nWhat to do\n  1. "), "{}", said.out);
    let answer: Value = serde_json::from_str(&bench.read("answer/diagnosis.json")).unwrap();
    // Three short records may not decide whether the friction falls with speed. The answer then names the
    // next experiment.
    let is_open = answer["verdict"] == "ambiguous";
    assert!(is_open || answer["verdict"] == "explained", "{}", answer["verdict"]);
    assert_eq!(exists(bench.path("answer/next-experiment.csv")), answer["next_experiment"].is_object());
    assert!(!is_open || answer["next_experiment"].is_object());
    assert_eq!(answer["where"][0]["place"], "guide");
    let level = &answer["effects"][0]["parameters"]["level"];
    assert!((level["value"].as_f64().unwrap() / LEVEL_N - 1.0).abs() < RIGHT, "{level}");
    assert_eq!(level["unit"], "N");
    for key in ["before", "refit", "after", "floor", "closed"] {
        assert!(answer["gap"][key].is_f64(), "{key}");
    }
    let page = bench.read("answer/report.html");
    for heading in [
        "How far the gap shrinks",
        "Where it lies",
        "The force that is missing",
        "Measured against predicted",
        "What was tried",
        "<ol>\n<li>",
        "log odds",
    ] {
        assert!(page.contains(heading), "{heading}");
    }

    let ran = bench.feeler(&["run", "answer/machine.toml", "--out", "again"]);
    assert_eq!(ran.code, DONE, "{}", ran.err);
    let replayed = bench.feeler(&["replay", "answer/machine.toml", "cases/records", "--out", "replayed"]);
    assert_eq!(replayed.code, DONE, "{}", replayed.err);
    let errors: Value = serde_json::from_str(&bench.read("replayed/replay.json")).unwrap();
    let error = |json: &Value| json["experiments"][2]["errors"][0]["relative_in_windows"].as_f64().unwrap();
    bench.feeler(&["replay", "cases/records/machine.toml", "cases/records", "--out", "believed"]);
    let believed: Value = serde_json::from_str(&bench.read("believed/replay.json")).unwrap();
    assert!(error(&errors) < 0.1 * error(&believed), "{errors}");
    let (measured, predicted) = (bench.read("cases/records/2.csv"), bench.read("replayed/2.csv"));
    assert_eq!(measured.lines().next(), predicted.lines().next());
    let stamps = |text: &str| {
        text.lines()
            .skip(1)
            .map(|line| line.split(',').next().unwrap().parse::<f64>().unwrap().to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(stamps(&measured), stamps(&predicted));

    let ran = bench.feeler(&["blind", "run", ".", "--answers", "answers"]);
    assert_eq!(ran.code, DONE, "{}", ran.err);
    bench.write(
        "truth.json",
        r#"[{"case": "records", "effects": [
            {"kind": "coulomb-friction", "place": "guide", "parameters": {"level": 4.0}}
        ]}]"#,
    );
    let scored = bench.feeler(&["blind", "score", ".", "--answers", "answers", "--truth", "truth.json"]);
    assert_eq!(scored.code, DONE, "{}", scored.err);
    let score: Value = serde_json::from_str(&bench.read("answers/score.json")).unwrap();
    assert_eq!(score["cases"][0]["right"], true);
    assert!(bench.read("answers/score.html").contains("Confusion"));
}

/// The machine file has the effects found, rounded as in the repaired machine. Its old text is kept. The old
/// file is restored.
fn is_applied(bench: &Bench, believed: &str, said: &str) {
    let changed = bench.read("cases/records/machine.toml");
    assert!(said.contains("\nchanged ") && said.contains("machine.toml.bak"), "{said}");
    assert_eq!(bench.read("cases/records/machine.toml.bak"), believed);
    assert!(changed.contains("# weighed"), "{changed}");
    let number = |text: &str, key: &str| {
        let table: toml::Table = toml::from_str(text).unwrap();
        let mut at = &toml::Value::Table(table);
        for part in key.split('.') {
            at = &at[part];
        }
        at.as_float().unwrap()
    };
    let repaired = bench.read("answer/machine.toml");
    let level = "springs.guide.effects.coulomb-friction.level";
    assert_eq!(number(&changed, level).to_bits(), number(&repaired, level).to_bits());
    for key in [level, "bodies.tip.mass", "springs.guide.damping"] {
        let digits = number(&repaired, key).to_string();
        let digits = digits.trim_start_matches(['0', '.']).chars().filter(char::is_ascii_digit).count();
        assert!(digits <= 6, "{key}: {repaired}");
    }
    bench.write("cases/records/machine.toml", AXIS);
}

#[test]
fn truth_blind_cases_are_made_repeatably_and_their_truth_is_sealed() {
    let bench = Bench::new();
    for out in ["a", "b"] {
        let said = bench.feeler(&["blind", "make", "--cases", "1", "--seed", "5", "--out", out]);
        assert_eq!(said.code, DONE, "{}", said.err);
    }
    for file in ["truth.sealed", "cases/case-000/press-1.csv", "held-back/case-000/dataset.toml"] {
        assert_eq!(bench.read(&format!("a/{file}")), bench.read(&format!("b/{file}")), "{file}");
    }
    assert!(!bench.read("a/truth.sealed").contains("case-000"));
    let checked = bench.feeler(&["check", "a/cases/case-000/dataset.toml"]);
    assert_eq!(checked.code, DONE, "{}", checked.err);
    let early = bench.feeler(&["blind", "score", "a"]);
    assert_eq!(early.code, BAD_INPUT);
    assert!(
        early.err.contains("no case has been answered") && early.err.contains("feeler blind run a"),
        "{}",
        early.err
    );
    assert!(!exists(bench.path("a/answers")));
}

#[test]
fn truth_wild_cases_are_made_repeatably_and_are_read_as_they_are() {
    are_made_repeatably_and_read("--wild");
}

#[test]
fn truth_servo_cases_are_made_repeatably_and_are_read_as_they_are() {
    are_made_repeatably_and_read("--servo");
}

fn are_made_repeatably_and_read(kind: &str) {
    let bench = Bench::new();
    for out in ["a", "b"] {
        let said = bench.feeler(&["blind", "make", kind, "--cases", "4", "--seed", "5", "--out", out]);
        assert_eq!(said.code, DONE, "{}", said.err);
    }
    for case in 0..4 {
        for group in ["cases", "held-back"] {
            let file = format!("{group}/case-{case:03}/dataset.toml");
            assert_eq!(bench.read(&format!("a/{file}")), bench.read(&format!("b/{file}")));
            let checked = bench.feeler(&["check", &format!("a/{file}")]);
            assert_eq!(checked.code, DONE, "{file}: {}", checked.err);
        }
    }
    let truth = bench.read("a/truth.sealed");
    assert_eq!(truth, bench.read("b/truth.sealed"));
    assert!(!truth.contains("case-000"));
}

#[test]
fn truth_records_that_cannot_be_used_are_named_with_what_to_do() {
    let bench = Bench::new();
    bench.write("machine.toml", AXIS);
    bench.write("dataset.toml", &format!("{COLUMNS}[[experiments]]\nfile = \"a.csv\"\n"));
    let mut rows = "t_s,drive.command,encoder.reading,accelerometer.reading\n".to_owned();
    for k in 0..200 {
        let _ = writeln!(rows, "{},1.0,{},{}", 1e-3 * f64::from(k), 1e-4 * f64::from(k), f64::from(k % 7));
    }
    bench.write("a.csv", &rows);
    let said = bench.feeler(&["diagnose", ".", "--out", "answer"]);
    assert_eq!(said.code, BAD_INPUT);
    assert!(
        said.err.contains("a.csv: `drive.command`: the command never changes\n  help: excite the drive"),
        "{}",
        said.err
    );
    let said = bench.feeler(&["diagnose", "nowhere"]);
    assert_eq!(said.code, BAD_INPUT, "{}", said.err);
}

/// Time beyond the budget, in times of a diagnosis without any, which does what cannot be left out. The
/// promise is a deadline, not a speed: this measures how fast and how busy the computer is.
const MARGIN: u32 = 5;

/// The example needs half a minute or more. In less, its answer is whole and names what was not tried.
#[test]
fn truth_a_diagnosis_ends_within_its_budget() {
    let bench = Bench::new();
    let dataset = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/datasets/bench-axis");
    let within = |budget: &str| {
        let begun = Instant::now();
        let said = bench.feeler(&["diagnose", dataset, "--budget", budget, "--out", "answer", "--json"]);
        (serde_json::from_str::<Value>(&said.out).expect("an answer"), begun.elapsed())
    };
    let (_, least) = within("0.1 s");
    let (answer, took) = within("3 s");
    assert!(took < Duration::from_secs(3) + MARGIN * least, "{took:?}, without any {least:?}");
    assert!(answer["gap"]["refit"].is_number() && !answer["cells"].as_array().unwrap().is_empty());
    let left = |attempt: &&Value| attempt["why"].as_str().unwrap().starts_with("not tried: the time");
    let untried = answer["attempts"].as_array().unwrap().iter().filter(left).count();
    let shortfalls = answer["adequacy"]["shortfalls"].as_array().unwrap();
    let said = shortfalls.iter().find(|short| short["condition"] == "tried").expect("it is said");
    let said = said["what"].as_str().unwrap();
    assert!(untried > 0 && said.contains(&format!("{untried} causes")), "{untried}: {said}");
}
