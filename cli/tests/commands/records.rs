//! `feeler frf` on the records of datasets: the chosen estimator and its result.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use feeler_lti::C64;
use serde_json::Value;

use crate::bench::{json, printed, refused};

/// The machine of the synthetic records: one free mass with a viscous guide, and its sensors.
const MACHINE: &str = r#"
name = "free-mass"
[bodies.motor]
mass = 12.0
[springs.guide]
between = ["ground", "motor"]
damping = 50.0
[actuators.drive]
on = "motor"
kind = "force"
[sensors.accelerometer]
reads = "motor.acceleration"
"#;
const DATASET: &str = r#"
name = "free-mass"
machine = "machine.toml"
[columns.command_n]
signal = "drive.command"
[columns.acceleration_mps2]
signal = "accelerometer.reading"
[[experiments]]
file = "record.csv"
engagement = "free"
"#;
const MASS_KG: f64 = 12.0;
const DAMPING: f64 = 50.0;
const ROW_S: f64 = 1e-3;

/// A dataset with one record of the free mass under a command, solved exactly between rows. The acceleration
/// at a row is read before the row's command acts.
fn record(command: impl Fn(usize) -> f64, rows: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let keeps = (-DAMPING * ROW_S / MASS_KG).exp();
    let (mut text, mut speed, mut acts) = (String::from("t_s,command_n,acceleration_mps2\n"), 0.0, 0.0);
    for k in 0..rows {
        let u = command(k);
        writeln!(text, "{:.4},{u},{}", k as f64 * ROW_S, (acts - DAMPING * speed) / MASS_KG).unwrap();
        speed = keeps * speed + (1.0 - keeps) * u / DAMPING;
        acts = u;
    }
    for (name, text) in [("machine.toml", MACHINE), ("dataset.toml", DATASET), ("record.csv", &text)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn path(folder: &Path) -> &str {
    folder.to_str().unwrap()
}

/// A portable draw from [0, 1): the fractional part of a large sine.
fn draw(k: usize) -> f64 {
    (((k as f64 + 1.0) * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0)
}

/// Frequencies without a common period of a few seconds.
fn frequencies_hz() -> Vec<f64> {
    let mut all = vec![1.7];
    while all[all.len() - 1] < 150.0 {
        let last = all[all.len() - 1];
        all.push(last + if last < 20.0 { 1.313 } else { 4.717 });
    }
    all
}

fn sum_of_sines(frequencies_hz: &[f64]) -> impl Fn(usize) -> f64 + use<> {
    let all: Vec<(f64, f64)> = frequencies_hz.iter().enumerate().map(|(i, f)| (*f, TAU * draw(i))).collect();
    move |k| all.iter().map(|(f, phase)| (TAU * f * k as f64 * ROW_S + phase).sin()).sum()
}

fn complex(values: &Value) -> Vec<C64> {
    let one = |value: &Value| C64::new(value[0].as_f64().unwrap(), value[1].as_f64().unwrap());
    values.as_array().unwrap().iter().map(one).collect()
}

/// Ratio of measured to linear response, with the frequency (Hz) and the radius of the confidence band over
/// the linear response.
fn ratios(found: &Value) -> Vec<(f64, C64, f64)> {
    let (measured, linear) = (complex(&found["response"]), complex(&found["linear"]));
    let frequencies = found["frequencies_hz"].as_array().unwrap().iter().map(|f| f.as_f64().unwrap());
    let high = found["magnitude_band"].as_array().unwrap().iter().map(|band| band[1].as_f64().unwrap());
    let all = frequencies.zip(measured.iter().zip(&linear)).zip(high);
    all.map(|((f, (g, l)), high)| (f, g / l, (high - g.norm()) / l.norm())).collect()
}

fn notes(found: &Value) -> String {
    found["notes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|note| note.as_str().unwrap())
        .collect::<Vec<_>>()
        .join("; ")
}

/// The mass starts at rest, with a transient of tau = 0.24 s. Hann's window over T = 4 s reduces it to the
/// share 2 tau^3 (pi / T)^2 / (1 + (w tau)^2)^1.5 over T / 4 of its initial size. That is 6e-4 at the lowest
/// line of 1.7 Hz. About ten sines excite it.
const TRANSIENT: f64 = 5e-3;

#[test]
fn truth_a_record_of_sines_is_evaluated_at_its_sines() {
    let wanted = frequencies_hz();
    let folder = record(sum_of_sines(&wanted), 4000);
    let found = json(&["frf", path(folder.path()), "--json"]);
    assert!(
        found["how"].as_str().unwrap().contains("sum of sines") && notes(&found).contains("fitted together"),
        "{found}"
    );
    let ratios = ratios(&found);
    assert_eq!(ratios.len(), wanted.len());
    for ((f, ratio, _), wanted) in ratios.iter().zip(&wanted) {
        assert!((f - wanted).abs() < 1e-3 && (ratio - 1.0).norm() < TRANSIENT, "{f} Hz: {ratio}");
    }
}

#[test]
fn truth_the_estimator_follows_from_the_command() {
    // Local polynomials and smoothed lines leave a local remainder. Averaged segments leak some per cent of a
    // response without resonances. Whole periods leave the transient that remains after one period.
    let lines: Vec<f64> = (2..150).map(f64::from).collect();
    let multisine = record(sum_of_sines(&lines), 5000);
    let noise = record(|k| draw(k) + draw(k + 100_000) + draw(k + 200_000) - 1.5, 8000);
    let chirp = record(
        |k| if k < 6000 { (TAU * (1.0 + 10.0 * k as f64 * ROW_S) * k as f64 * ROW_S).sin() } else { 0.0 },
        8000,
    );
    let cases = [
        (&multisine, "lines of 5 periods of 1 s", "repeats every 1 s, 5 times", 0.02),
        (&noise, "local polynomials", "noise with power in its whole band", 0.02),
        (&chirp, "chirp, H1", "even and smooth", 0.05),
    ];
    for (folder, how, why, tolerance) in cases {
        let found = json(&["frf", path(folder.path()), "--from", "2", "--to", "100", "--json"]);
        assert!(
            found["how"].as_str().unwrap().contains(how) && notes(&found).contains(why),
            "{how}: {} {}",
            found["how"],
            found["notes"]
        );
        for (f, ratio, _) in ratios(&found) {
            assert!((ratio - 1.0).norm() < tolerance, "{how}: {f} Hz: {ratio}");
        }
    }
}

#[test]
fn truth_frequencies_of_which_a_record_says_nothing_are_left_out() {
    let steps = record(|k| [1.0, 4.0, 2.0, 8.0][k / 1000], 4000);
    let found = json(&["frf", path(steps.path()), "--json"]);
    assert!(
        found["how"].as_str().unwrap().contains("H1 of segments")
            && notes(&found).contains("neither sines nor even noise")
    );
    let pressed = printed(&["frf", "datasets/bench-axis", "--experiment", "press-1.csv"]);
    assert!(
        pressed.contains("frequencies are left out: other inputs to the machine outweigh the command"),
        "{pressed}"
    );
    assert!(pressed.contains("Coherence is below 0.8 at"), "{pressed}");
    let still = record(|_| 3.0, 4000);
    let said = refused(&["frf", path(still.path())]);
    assert!(said.contains("help:"), "{said}");
}

/// The bench's commands arrive 1.92 ms late, and its masses differ by up to a tenth from the believed ones.
/// Above 25 Hz speeds are about 0.03 m/s. There its dry friction of 7.5 N is equivalent to a viscous damping
/// of sqrt(2 / pi) 7.5 / 0.03 = 200 N s/m. It adds 200 / (12 * 2 pi 25) = 0.1 at 25 Hz and less above.
const BELIEVED: f64 = 0.1;
const FRICTION_AT_25_HZ: f64 = 0.1;

#[test]
fn regress_the_bench_axis_is_measured_where_it_was_excited() {
    let bench = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../scenarios/datasets/bench-axis");
    let folder = tempfile::tempdir().unwrap();
    for file in fs::read_dir(&bench).unwrap().map(|entry| entry.unwrap().path()) {
        fs::copy(&file, folder.path().join(file.file_name().unwrap())).unwrap();
    }
    let machine = fs::read_to_string(bench.join("machine.toml")).unwrap();
    let late = format!("{machine}\n[actuators.drive.effects.command-delay]\ndelay = \"1.92 ms\"\n");
    fs::write(folder.path().join("machine.toml"), late).unwrap();
    let found = json(&["frf", path(folder.path()), "--json"]);
    let ratios = ratios(&found);
    // Sines 1.3 Hz apart up to 20 Hz, and 4.7 Hz apart from there to 160 Hz. The first sine is below two
    // periods per record.
    assert_eq!(ratios.len(), 44);
    for (f, ratio, radius) in ratios.iter().filter(|(f, ..)| *f > 24.0) {
        let off = (ratio - 1.0).norm();
        assert!(off < radius + BELIEVED + FRICTION_AT_25_HZ * 25.0 / f, "{f} Hz: {ratio}, band {radius}");
    }
    // Friction opposes the slow motion.
    assert!(ratios.iter().filter(|(f, ..)| *f < 6.5).all(|(_, ratio, _)| ratio.norm() < 0.9));
    assert!(printed(&["frf", path(&bench)]).contains("fitted together"));
}

#[test]
fn regress_check_names_what_is_wrong_with_the_rows_of_a_dataset() {
    let folder = record(|k| draw(k) - 0.5, 400);
    crate::bench::printed(&["check", path(folder.path())]);
    let file = folder.path().join("record.csv");
    let sound = fs::read_to_string(&file).unwrap();
    let lines: Vec<&str> = sound.lines().collect();
    let without =
        |rows: std::ops::Range<usize>| [&lines[..rows.start], &lines[rows.end..]].concat().join("\n");
    let mut back = lines.clone();
    back.swap(200, 201);
    let cases = [
        (back.join("\n"), "record.csv:202: the time stamp does not advance"),
        (without(200..250), "record.csv:201: 0.0500 s are missing"),
    ];
    for (text, expected) in cases {
        fs::write(&file, text).unwrap();
        let said = crate::bench::refused(&["check", path(folder.path())]);
        assert!(said.contains(expected), "{expected}: {said}");
    }
    // A gap that interpolation repairs is a warning, with the assumption.
    fs::write(&file, sound.replacen(lines[200], "0.1990,0.1,nan", 1)).unwrap();
    let said = printed(&["check", path(folder.path())]);
    assert!(said.starts_with("ok ") && said.contains("record.csv:201: `acceleration_mps2`"), "{said}");
    fs::write(&file, without(200..201)).unwrap();
    let said = printed(&["check", path(folder.path())]);
    assert!(
        said.starts_with("ok ") && said.contains("warning: record.csv:201: a row is missing before this one"),
        "{said}"
    );
}

#[test]
fn regress_what_the_check_warns_of_is_said_with_the_response() {
    let bench = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../scenarios/datasets/bench-axis");
    let folder = tempfile::tempdir().unwrap();
    for file in fs::read_dir(&bench).unwrap().map(|entry| entry.unwrap().path()) {
        let mut bytes = fs::read(&file).unwrap();
        if file.ends_with("free-sines-1.csv") {
            let text = String::from_utf8(bytes).unwrap();
            bytes = text
                .lines()
                .enumerate()
                .filter(|(i, _)| *i != 400)
                .flat_map(|(_, line)| [line, "\n"])
                .collect::<String>()
                .into_bytes();
        }
        fs::write(folder.path().join(file.file_name().unwrap()), bytes).unwrap();
    }
    let said = "a row is missing before this one (the rows between were bridged and count as unknown; \
                check the recorder's buffer if there are more)";
    let found = json(&["frf", path(folder.path()), "--experiment", "free-sines-1.csv", "--json"]);
    let notes: Vec<&str> =
        found["notes"].as_array().unwrap().iter().map(|note| note.as_str().unwrap()).collect();
    assert!(
        notes.iter().any(|note| note.starts_with("free-sines-1.csv:401") && note.ends_with(said)),
        "{notes:?}"
    );
    assert!(printed(&["frf", path(folder.path()), "--experiment", "free-sines-1.csv"]).contains(said));
    // An experiment that is not requested is only counted.
    let other = printed(&["frf", path(folder.path()), "--experiment", "free-sines-2.csv"]);
    assert!(!other.contains(said) && other.contains("on the other experiments"), "{other}");
}
