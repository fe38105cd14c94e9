//! `feeler import` for programs.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use serde_json::Value;

use crate::bench::{Bench, DONE};

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
