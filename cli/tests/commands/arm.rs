//! `feeler run` of a whole arm, and the other commands on its file.

use std::path::Path;

use crate::bench::{BAD_INPUT, Bench, DONE, exists};

fn press() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/arms/press-low-gain.toml").display().to_string()
}

#[test]
fn truth_a_run_of_an_arm_writes_its_results_and_a_page_that_shows_it_move() {
    let bench = Bench::new();
    let said = bench.feeler(&["run", &press(), "--set", "run.duration=0.3", "--out", "here", "--csv"]);
    assert_eq!((said.code, said.err.as_str()), (DONE, ""));
    assert!(said.out.contains("per simulated second"), "{}", said.out);
    for name in ["trace.parquet", "trace.csv", "summary.json", "report.html"] {
        assert!(exists(bench.path("here").join(name)), "{name}");
    }
    let summary: serde_json::Value = serde_json::from_str(&bench.read("here/summary.json")).unwrap();
    assert!(
        summary["peak_force_n"].as_f64().unwrap() > 1.0
            && summary["wall_s_per_simulated_s"].as_f64().unwrap() > 0.0
    );
    assert_eq!(
        (&summary["events"][0]["what"], summary["contacts"][0]["name"].as_str()),
        (&"slip".into(), Some("tool"))
    );
    let trace = bench.read("here/trace.csv");
    let header = trace.lines().next().unwrap();
    for name in [
        "tool.force",
        "force.reading",
        "joints.elbow.position",
        "joints.elbow.motor",
        "tool.turn_z",
        "point.x",
        "normal.z",
    ] {
        assert!(header.split(',').any(|column| column == name), "{name} in {header}");
    }
    // 0.3 s at 1 kHz with both ends, and a header.
    assert_eq!(trace.lines().count(), 302);
    let page = bench.read("here/report.html");
    assert!(page.contains("data-scene=\"0\"") && page.contains("\"frames\":[[0"));
    assert!(
        !page.contains("http://")
            || page.matches("http://").count() == page.matches("http://www.w3.org").count()
    );
}

#[test]
fn truth_other_commands_take_the_axis_and_say_so() {
    let bench = Bench::new();
    let checked = bench.feeler(&["check", &press()]);
    assert!(
        checked.code == DONE && checked.out.contains("an arm with 6 joints on a mesh"),
        "{}",
        checked.out
    );
    for command in ["analyze", "frf", "sweep", "why"] {
        let said = bench.feeler(&[command, &press()]);
        assert_eq!(said.code, BAD_INPUT, "{command}");
        assert!(said.err.contains("feeler reduce"), "{command}: {}", said.err);
    }
    let said = bench.feeler(&["run", &press(), "--engine", "rapier"]);
    assert!(said.code == BAD_INPUT && said.err.contains("run.engine"), "{}", said.err);
}

/// A URDF whose inertias lack a product is read, with a warning wherever the arm is used.
#[test]
fn truth_commands_warn_of_an_arm_whose_urdf_lacks_something() {
    let bench = Bench::new();
    let arms = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/arms");
    for name in ["six-joint.toml", "press-low-gain.toml", "dome.obj"] {
        std::fs::copy(arms.join(name), bench.path(name)).unwrap();
    }
    let urdf = std::fs::read_to_string(arms.join("six-joint.urdf")).unwrap();
    bench.write("six-joint.urdf", &urdf.replace(" ixy=\"0\"", ""));
    let pose = ["--pose", "0,-0.5,1.0,0,0.5,0", "--normal", "0,0,-1"];
    for command in [
        [&["reduce", "six-joint.toml"], &pose[..]].concat(),
        vec!["check", "press-low-gain.toml"],
        vec!["run", "press-low-gain.toml", "--set", "run.duration=0.01"],
    ] {
        let said = bench.feeler(&command);
        assert_eq!(said.code, DONE, "{command:?}: {}", said.err);
        assert!(format!("{}{}", said.out, said.err).contains("lacks `ixy`"), "{command:?}: {}", said.err);
    }
}

#[test]
fn truth_a_page_with_sliders_is_refused_with_the_commands_that_give_one() {
    let bench = Bench::new();
    let said = bench.feeler(&["live", &press()]);
    assert!(said.code == BAD_INPUT && said.err.contains("takes seconds"), "{}", said.err);
    let (_, command) = said.err.split_once("feeler reduce ").unwrap();
    let (command, then) = command.split_once(", then ").unwrap();
    assert!(then.starts_with("feeler live axis.toml"), "{then}");
    let words: Vec<&str> = std::iter::once("reduce").chain(command.split_whitespace()).collect();
    let made = bench.feeler(&words);
    assert_eq!(made.code, DONE, "{command}: {}", made.err);
    let checked = bench.feeler(&["check", "axis.toml"]);
    assert!(checked.code == DONE && checked.out.contains("1 controller"), "{}", checked.out);
    let axis = bench.read("axis.toml");
    assert!(axis.contains("other directions held") && axis.contains("stiffness = 20000"), "{axis}");
}
