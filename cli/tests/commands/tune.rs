//! `feeler tune`.

use std::fs;

use crate::bench::{json, printed, refused};

const FILE: &str = "paper/flexible-contact.toml";

#[test]
fn truth_a_tuned_file_keeps_its_comments_and_does_what_was_said() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("tuned.toml");
    let code = folder.path().join("code");
    let (tuned, written) = (out.to_str().unwrap(), code.to_str().unwrap());
    let said = printed(&["tune", FILE, "--set", "run.duration=1", "--out", tuned, "--code", written]);
    for word in [
        "phase margin",
        "runs: 1",
        "controllers.force.kp=",
        "stop above",
        "KP = ",
        "next: feeler compare ",
        "--spec \"gains = kp+damping\"",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
    assert_eq!(said.matches("\nwrote\n").count(), 1, "{said}");
    let text = fs::read_to_string(&out).unwrap();
    assert!(text.contains("# f_a = f_d + kp (f_d - f_s)") && text.contains("duration = 1"), "{text}");
    assert!(text.contains("name    = \"tuned\""), "{text}");
    let found = json(&["analyze", tuned, "--json"]);
    assert!(found["margins"]["phase_deg"].as_f64().unwrap() >= 45.0);
    let [c, rust] =
        ["controller.c", "controller.rs"].map(|name| fs::read_to_string(code.join(name)).unwrap());
    assert!(c.contains("double controller_sample(") && rust.contains("pub fn sample("), "{c}{rust}");
}

#[test]
fn truth_a_diagnosis_is_drawn_from_and_its_effects_stay_out_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let estimate = r#"{ "value": 2.0, "ci90": [-0.5, 4.5], "unit": "N" }"#;
    let parameters = format!(r#""parameters": {{ "level": {estimate} }}"#);
    let of = r#""kind": "coulomb-friction", "on": "springs.guide", "accepted": true"#;
    let effect = format!("{{ {of}, {parameters} }}");
    let diagnosis = folder.path().join("diagnosis.json");
    fs::write(&diagnosis, format!(r#"{{ "effects": [{effect}] }}"#)).unwrap();
    let out = folder.path().join("tuned.toml");
    let (folder, tuned) = (folder.path().to_str().unwrap(), out.to_str().unwrap());
    let found = json(&[
        "tune",
        FILE,
        "--set",
        "run.duration=1",
        "--diagnosis",
        folder,
        "--draws",
        "7",
        "--out",
        tuned,
        "--json",
    ]);
    assert_eq!(found["machines"], 8);
    let runs = found["runs"]["outcomes"].as_object().unwrap().values();
    assert_eq!(runs.map(|count| count.as_u64().unwrap()).sum::<u64>(), 8);
    assert!(!fs::read_to_string(&out).unwrap().contains("coulomb-friction"));
}

#[test]
fn truth_each_mistake_is_one_error_with_its_remedy() {
    for (arguments, what, remedy) in [
        (["--spec", "phase margin <= 45 deg"], "bounds the wrong side", "write phase margin >= 45 deg"),
        (["--spec", "gains = kq"], "no gain `kq`", "name one of kp"),
        (["--diagnosis", "nowhere"], "nowhere", "`feeler diagnose` wrote"),
    ] {
        let said = refused(&["tune", FILE, arguments[0], arguments[1]]);
        assert!(said.contains(what) && said.contains(remedy), "{arguments:?}: {said}");
        assert_eq!(said.matches("error:").count(), 1, "{said}");
    }
}
