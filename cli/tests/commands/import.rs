//! `feeler import` for programs.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use serde_json::Value;

use crate::bench::{BAD_INPUT, Bench, DONE};

const ROW_S: f64 = 0.01;
const LAG_ROWS: usize = 6;

/// Ten seconds of a joint that follows a target of two sines, six rows later.
fn log() -> String {
    let target = |k: usize| {
        let t_s = k as f64 * ROW_S;
        0.4 * (TAU * 0.5 * t_s).sin() + 0.2 * (TAU * 1.3 * t_s).sin()
    };
    let mut text = String::from("t_s,target_rad,position_rad\n");
    for k in 0..1000 {
        let _ = writeln!(text, "{:.2},{},{}", k as f64 * ROW_S, target(k + LAG_ROWS), target(k));
    }
    text
}

#[test]
fn truth_an_import_for_programs_holds_rows_roles_and_the_lag_of_the_position() {
    let bench = Bench::new();
    bench.write("joint.csv", &log());
    let said = bench.feeler(&["import", "joint.csv", "--json"]);
    assert_eq!(said.code, DONE, "{}", said.err);
    let found: Value = serde_json::from_str(&said.out).unwrap();
    let table = &found["runs"][0]["tables"][0];
    assert_eq!(table["rows"], 1000);
    assert_eq!(table["lost_rows"], 0);
    assert_eq!((&table["clock"]["column"], &table["clock"]["unit"]), (&"t_s".into(), &"s".into()));
    assert!((table["rate_hz"].as_f64().unwrap() - 100.0).abs() < 1e-6, "{table}");
    let role = |name: &str| {
        let columns = table["columns"].as_array().unwrap();
        columns.iter().find(|column| column["name"] == name).unwrap()["role"].clone()
    };
    assert_eq!((role("target_rad"), role("position_rad")), ("target".into(), "position".into()));
    let joint = &found["joints"][0];
    let lag_s = joint["lag_s"].as_f64().unwrap();
    // The lag is searched in steps of 2.5 ms.
    assert!((lag_s - LAG_ROWS as f64 * ROW_S).abs() <= 0.0025, "{joint}");
    assert!(joint["correlation"].as_f64().unwrap() > 0.999, "{joint}");
    assert_eq!(found["datasets"], Value::Array(Vec::new()), "nothing is written without --out");
}

/// A user's mistake ends with code 2, and its message names the place.
#[test]
fn truth_a_mistake_in_a_log_ends_with_its_row_or_column_and_bad_input() {
    let log = log();
    let row = |k: usize| log.lines().nth(k).unwrap().to_owned();
    let with_row = |k: usize, text: &str| log.replacen(&row(k), text, 1);
    let later = log.lines().skip(1).fold("t_s,target_rad\n".to_owned(), |mut text, row| {
        let cells: Vec<&str> = row.split(',').collect();
        let _ = writeln!(text, "{},{}", 1e3 + cells[0].parse::<f64>().unwrap(), cells[1]);
        text
    });
    let mut only_position = "t_s,position_rad\n".to_owned();
    log.lines().skip(1).for_each(|row| {
        let cells: Vec<&str> = row.split(',').collect();
        let _ = writeln!(only_position, "{},{}", cells[0], cells[2]);
    });
    for (name, text, said) in [
        ("long", with_row(100, &(row(100) + ",7")), "row 101: it has 4 cells, but there are 3 columns"),
        ("quote", with_row(100, &row(100).replacen(',', ",\"", 1)), "row 101: a quote opens here"),
        ("back", with_row(100, &row(100).replacen("0.99", "0.5", 1)), "row 101: the clock `t_s` goes back"),
        ("unit", log.replacen("target_rad", "target [furlong]", 1), "`furlong` is not a unit"),
        ("only", only_position.clone(), "no joint has both"),
    ] {
        let bench = Bench::new();
        bench.write("log.csv", &text);
        let found = bench.feeler(&["import", "log.csv", "--out", "made"]);
        let told = format!("{}{}", found.out, found.err).split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(found.code, BAD_INPUT, "{name}: {told}");
        assert!(told.contains(said), "{name}: {told}");
    }
    // Two files of one run whose clocks have nothing in common.
    let bench = Bench::new();
    std::fs::create_dir(bench.path("run")).unwrap();
    bench.write("run/target.csv", &later);
    bench.write("run/position.csv", &only_position);
    let found = bench.feeler(&["import", "run", "--out", "made"]);
    assert!(found.code == BAD_INPUT && found.err.contains("share no time"), "{}", found.err);
}

/// Faults that do not stop an import have a note with their row.
#[test]
fn truth_short_rows_and_columns_of_one_name_are_noted() {
    let bench = Bench::new();
    let log =
        log().replacen("t_s,target_rad,position_rad\n", "t_s,target_rad,position_rad,position_rad\n", 1);
    bench.write("log.csv", &log);
    let found = bench.feeler(&["import", "log.csv"]);
    assert_eq!(found.code, DONE, "{}", found.err);
    let told = found.out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(told.contains("row 2 has 3 of 4 cells (1000 such rows)"), "{told}");
    assert!(told.contains("two columns are called `position_rad`"), "{told}");
}
