//! `feeler frf`.

use std::io::Write as _;
use std::path::PathBuf;

use serde_json::Value;

use crate::bench::{json, printed, refused};

/// Difference between closed-form and simulated responses of a linear machine under noise: leakage of local
/// polynomials near a resonance with 2 % damping.
const LEAKAGE_DB: f64 = 0.05;

/// Error of a line within 0.1 Hz of the corner of a first-order filter: at most 1 % of the modulus.
const FILTERED: f64 = 0.01;

/// Excitation with 0.1 N rms about 30 N. The tangent and the transient to 30 N cause half a decibel at the
/// resonance of the stiffest law. A tangent at another force would shift the resonance and cause tens of
/// decibels.
const SMALL_SIGNAL_DB: f64 = 1.0;

#[test]
fn truth_a_response_is_linearised_under_the_mean_of_its_command() {
    let difference_db = |file: &str, offset: &str| {
        let found = json(&[
            "frf",
            file,
            "--offset",
            offset,
            "--rms",
            "0.1",
            "--from",
            "5",
            "--to",
            "100",
            "--excitation",
            "multisine",
            "--realisations",
            "2",
            "--periods",
            "2",
            "--json",
        ]);
        let sizes = |key: &str| -> Vec<f64> {
            let values = found[key].as_array().unwrap().iter();
            values.map(|v| v[0].as_f64().unwrap().hypot(v[1].as_f64().unwrap())).collect()
        };
        let pairs = sizes("response").into_iter().zip(sizes("linear"));
        pairs.map(|(measured, linear)| (20.0 * (measured / linear).log10()).abs()).fold(0.0, f64::max)
    };
    for file in [
        "effects/hertz-contact.toml",
        "effects/hardening-stiffness.toml",
        "effects/hunt-crossley-contact.toml",
    ] {
        let decibels = difference_db(file, "30");
        assert!(decibels < SMALL_SIGNAL_DB, "{file}: {decibels}");
    }
    assert!(refused(&["frf", "effects/hertz-contact.toml"]).contains("--offset"));
}

#[test]
fn truth_a_response_is_that_of_the_reading_which_the_controller_gets() {
    // At 20 Hz, a low-pass filter of the sensor with that corner causes 45 degrees and 3 dB.
    let measured = |output: &[&str]| {
        let found = json(
            &[
                &[
                    "frf",
                    "why/force-lag.toml",
                    "--clamped",
                    "--from",
                    "19.9",
                    "--to",
                    "20.1",
                    "--duration",
                    "20",
                    "--json",
                ],
                output,
            ]
            .concat(),
        );
        let value = &found["linear"][found["linear"].as_array().unwrap().len() / 2];
        (
            found["output"].as_str().unwrap().to_owned(),
            value[0].as_f64().unwrap().hypot(value[1].as_f64().unwrap()),
            found["output_reads"].clone(),
        )
    };
    let (name, reading, reads) = measured(&[]);
    assert_eq!((name.as_str(), &reads), ("force.reading", &Value::from("tool.spring_force")));
    let (_, force, _) = measured(&["--output", "tool.spring_force"]);
    assert!((reading / force / 0.5_f64.sqrt() - 1.0).abs() < FILTERED, "{reading} {force}");
}

#[test]
fn truth_every_excitation_measures_the_linear_response() {
    let excitations: [&[&str]; 4] = [
        &["--excitation", "white-noise"],
        &["--excitation", "multisine", "--realisations", "2"],
        &["--excitation", "chirp"],
        &["--excitation", "stepped-sine", "--points", "8"],
    ];
    for excitation in excitations {
        let found = json(
            &[&["frf", "paper/rigid.toml", "--from", "2", "--to", "200", "--json"], excitation].concat(),
        );
        let agreement = &found["agreement"];
        assert!(agreement["frequencies_compared"].as_u64().unwrap() >= 8, "{excitation:?}");
        assert!(
            agreement["largest_difference_db"].as_f64().unwrap() < LEAKAGE_DB,
            "{excitation:?}: {agreement}"
        );
        assert_eq!(
            found["frequencies_hz"].as_array().unwrap().len(),
            found["linear"].as_array().unwrap().len()
        );
    }
}

#[test]
fn truth_a_response_is_written_as_page_table_and_json() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let text =
        printed(&["frf", "paper/flexible.toml", "--estimator", "hv", "--duration", "20", "--out", out]);
    assert!(text.contains("Hv of segments") && text.contains("coherence"));
    let csv = std::fs::read_to_string(folder.path().join("frf.csv")).unwrap();
    assert!(csv.starts_with("frequency_hz,magnitude_db,") && csv.lines().count() > 100);
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("Coherence,") && page.contains("Magnitude,"));
}

#[test]
fn truth_records_of_a_dataset_give_a_response() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/blind/practice/case-00");
    let Some(folder) = folder.canonicalize().ok().and_then(|f| f.to_str().map(str::to_owned)) else {
        // `eprintln!` would not be shown, because a passing test captures its output.
        let _ = writeln!(std::io::stderr(), "skipped: no practice datasets");
        return;
    };
    let found =
        json(&["frf", &folder, "--experiment", "clamped-1.csv", "--experiment", "clamped-2.csv", "--json"]);
    assert_eq!(found["output"], "force.reading");
    assert!(found["coherence"].as_array().unwrap().iter().all(Value::is_number));
    assert!(refused(&["frf", &folder, "--experiment", "clamped-9.csv"]).contains("did you mean `clamped-"));
    assert!(refused(&["frf", &folder, "--excitation", "multisine"]).contains("--period"));
}

#[test]
fn regress_sensor_noise_of_a_linear_machine_is_no_distortion() {
    let said = |machine: &str, setting: &str, seed: &str| {
        printed(&[
            "frf",
            machine,
            "--set",
            setting,
            "--excitation",
            "multisine",
            "--to",
            "100",
            "--seed",
            seed,
        ])
    };
    for seed in ["1", "2", "3"] {
        let text = said("paper/flexible.toml", "sensors.force.noise=0.02", seed);
        assert!(text.contains("nonlinear distortion none beyond the noise (it would show above -"), "{text}");
    }
    let text = said("effects/coulomb-friction.toml", "name=rubbing", "1");
    assert!(!text.contains("none beyond the noise"), "{text}");
}
