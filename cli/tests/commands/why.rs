//! `feeler why`.

use serde_json::Value;

use crate::bench::{BAD_INPUT, Bench, DONE, PRESS, exists};

const SUSTAINED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/chatter/sustained.toml");

#[test]
fn truth_a_file_written_with_a_remedy_no_longer_chatters_and_keeps_its_comments() {
    let bench = Bench::new();
    assert_eq!(bench.feeler(&["new", "chatter", "--out", "chatter.toml"]).code, DONE);
    let said = bench.feeler(&["why", "chatter.toml", "--try", "1", "--out", "cured.toml"]);
    assert_eq!(said.code, DONE, "{}", said.err);
    // The command prints the key that it sets, and changes nothing else in the file.
    let (key, _) = said.out.strip_prefix("cured.toml: ").and_then(|said| said.split_once('=')).unwrap();
    let said_next = said.out.trim_end().rsplit_once("next: feeler ").unwrap().1;
    assert_eq!(said_next, "compare chatter.toml cured.toml");
    let compared = bench.feeler(&said_next.split(' ').collect::<Vec<_>>());
    assert_eq!(compared.code, DONE, "{}", compared.err);
    let (before, after) = (bench.read("chatter.toml"), bench.read("cured.toml"));
    let mut changed: Vec<&str> =
        after.lines().filter(|line| !before.lines().any(|old| old == *line)).collect();
    let name = changed.remove(0);
    assert!(name.starts_with("name") && name.contains("\"cured\""), "{name}");
    assert!(!changed.is_empty() && changed.len() <= 3, "{changed:?}");
    assert!(changed[0].starts_with(key.rsplit('.').next().unwrap()), "{key}: {changed:?}");
    let comments = |text: &str| text.lines().filter(|line| line.contains('#')).count();
    assert_eq!(comments(&before), comments(&after));
    let outcome = |file: &str| -> Value {
        let ran = bench.feeler(&["run", file, "--json"]);
        assert_eq!(ran.code, DONE, "{}", ran.err);
        serde_json::from_str::<Value>(&ran.out).unwrap()["outcome"].take()
    };
    assert_eq!(outcome("chatter.toml"), "chatter");
    let baseline = bench.read("out/chatter/summary.json");
    let cured = outcome("cured.toml");
    assert!(exists(bench.path("out/cured/summary.json")));
    assert_eq!(bench.read("out/chatter/summary.json"), baseline, "what a remedy gives replaces nothing");
    assert!(["settled", "bounces-then-settles"].contains(&cured.as_str().unwrap()), "{cured}");
}

#[test]
fn truth_a_remedy_that_does_not_exist_is_refused_with_those_that_do() {
    let bench = Bench::new();
    let said = bench.feeler(&["why", SUSTAINED, "--try", "99", "--out", "cured.toml"]);
    assert_eq!(said.code, BAD_INPUT);
    assert!(said.err.contains("no remedy 99") && said.err.contains("try one of 1, 2"), "{}", said.err);
    assert!(!exists(bench.path("cured.toml")));
    bench.write("press.toml", PRESS);
    let said = bench.feeler(&["why", "press.toml", "--try", "1", "--out", "cured.toml"]);
    assert_eq!(said.code, BAD_INPUT);
    assert!(said.err.contains("it does not chatter") && said.err.contains("feeler tune"), "{}", said.err);
}

#[test]
fn truth_a_remedy_that_replaces_its_file_leaves_what_it_was_beside_it() {
    let bench = Bench::new();
    assert_eq!(bench.feeler(&["new", "chatter", "--out", "chatter.toml"]).code, DONE);
    let before = bench.read("chatter.toml");
    let said = bench.feeler(&["why", "chatter.toml", "--try", "1", "--out", "chatter.toml"]);
    assert_eq!(said.code, DONE, "{}", said.err);
    assert_ne!(bench.read("chatter.toml"), before);
    assert_eq!(bench.read("chatter.toml.bak"), before);
    assert!(said.out.contains("what it was is in chatter.toml.bak"), "{}", said.out);
    assert!(said.out.trim_end().ends_with("compare chatter.toml.bak chatter.toml"), "{}", said.out);
    // Another file that exists is kept too, and compared is the file of the command.
    bench.write("mine.toml", "# mine\n");
    let said = bench.feeler(&["why", "chatter.toml.bak", "--try", "1", "--out", "mine.toml"]);
    assert_eq!(said.code, DONE, "{}", said.err);
    assert_eq!(bench.read("mine.toml.bak"), "# mine\n");
    assert!(said.out.trim_end().ends_with("compare chatter.toml.bak mine.toml"), "{}", said.out);
}

#[test]
fn truth_what_a_check_doubts_stands_before_causes_theory_and_gains() {
    let bench = Bench::new();
    bench.write("away.toml", &PRESS.replace("[\"tip\", \"ground\"]", "[\"ground\", \"tip\"]"));
    for command in ["why", "analyze", "tune"] {
        let said = bench.feeler(&[command, "away.toml"]);
        let doubt = "warning: contacts.tool.between: a positive command of `drive` pulls";
        assert!(said.err.starts_with(doubt), "{command}: {}", said.err);
    }
}
