//! `feeler check`.

use serde_json::Value;

use crate::bench::{BAD_INPUT, Bench, CHECK_FAILED, DONE, PRESS};

#[test]
fn truth_sound_files_are_named_with_what_they_hold() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    bench.write("sweep.toml", "scenario = \"press.toml\"\n[axes]\n\"controllers.force.kp\" = [0.1, 0.2]\n");
    let said = bench.feeler(&["check", "press.toml", "sweep.toml"]);
    assert_eq!((said.code, said.err.as_str()), (DONE, ""));
    insta::assert_snapshot!(said.out);
}

#[test]
fn truth_all_mistakes_of_all_files_are_reported() {
    let bench = Bench::new();
    bench.write("good.toml", PRESS);
    bench.write(
        "bad.toml",
        &PRESS.replace("\"2 kg\"", "\"2 N\"").replace("reads        = \"force\"", "reads        = \"farce\""),
    );
    let said = bench.feeler(&["check", "bad.toml", "good.toml", "absent.toml"]);
    assert_eq!(said.code, BAD_INPUT);
    assert!(said.out.starts_with("ok  good.toml"));
    insta::assert_snapshot!(said.err);
}

#[test]
fn truth_json_holds_every_problem_with_its_place() {
    let bench = Bench::new();
    bench.write("bad.toml", &PRESS.replace("\"2 kg\"", "-2"));
    let said = bench.feeler(&["check", "bad.toml", "--json"]);
    assert_eq!(said.code, BAD_INPUT);
    let results: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(results[0]["ok"], false);
    assert_eq!(results[0]["problems"][0]["key"], "bodies.tip.mass");
    assert_eq!(results[0]["problems"][0]["line"], 5);
}

/// Millimetres in place of metres once ended in `ok` and exit code 0, below less important warnings.
#[test]
fn regress_a_unit_that_is_wrong_by_a_thousand_is_no_ok() {
    let bench = Bench::new();
    let from = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/datasets/bench-axis");
    for file in std::fs::read_dir(&from).unwrap().map(|entry| entry.unwrap().path()) {
        std::fs::copy(&file, bench.path(file.file_name().unwrap().to_str().unwrap())).unwrap();
    }
    let sound = bench.feeler(&["check", "."]);
    assert_eq!(sound.code, DONE, "{}", sound.err);
    // Slow strokes hardly move an accelerometer, which is not a mistake.
    assert!(sound.out.contains("note: strokes-2.csv") && !sound.out.contains("warning"), "{}", sound.out);
    let text = bench.read("dataset.toml");
    let column = "[columns.encoder_m]\n";
    assert!(text.contains(column), "{text}");
    bench.write("dataset.toml", &text.replace(column, &format!("{column}scale = 1000.0\n")));
    let said = bench.feeler(&["check", "."]);
    assert_eq!(said.code, CHECK_FAILED, "{}{}", said.out, said.err);
    let lines: Vec<&str> = said.out.lines().collect();
    assert!(lines[0].starts_with("wrong unit  ."), "{}", said.out);
    assert!(lines[1].contains("remove its `unit` or `scale`"), "{}", said.out);
    let json: Value = serde_json::from_str(&bench.feeler(&["check", ".", "--json"]).out).unwrap();
    assert_eq!(json[0]["ok"], false);
    assert!(json[0]["problems"][0]["message"].as_str().unwrap().contains("its own `unit`"), "{json}");
}
