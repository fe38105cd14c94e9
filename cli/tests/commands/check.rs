//! `feeler check`.

use serde_json::Value;

use crate::bench::{BAD_INPUT, Bench, DONE, PRESS};

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
