//! `feeler reduce`.

use std::path::Path;

use crate::bench::{BAD_INPUT, Bench, DONE};

/// Tolerance of the axis's phase crossover in contact against the whole arm, with the tool's other directions
/// held.
const HELD_CROSSOVER: f64 = 0.05;

#[test]
fn truth_an_arm_becomes_a_machine_that_other_commands_take() {
    let bench = Bench::new();
    let arm = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/arms/six-joint.toml");
    let arm = arm.to_str().unwrap();
    let map = ["--map", "0.5,0.7,2,-0.1,0.1,2", "--map-out", "map.csv"];
    let asked = ["reduce", arm, "--at", "0.65,0.1,0.1", "--normal", "0,0,-1", "--out", "axis.toml"];
    let said = bench.feeler(&[&asked[..], &map[..]].concat());
    assert_eq!(said.code, DONE, "{}", said.err);
    assert!(said.out.contains("effective mass") && said.out.contains("phase crossover"), "{}", said.out);
    assert_eq!(bench.read("map.csv").lines().count(), 5);
    let drawn =
        bench.feeler(&[&asked[..6], &["--map", "0.7,1.5,2,0.1,0.1,1", "--map-out", "map.html"]].concat());
    assert_eq!(drawn.code, DONE, "{}", drawn.err);
    let page = bench.read("map.html");
    assert!(page.contains("The arm reaches 1 of 2 places") && page.contains("out of reach"), "{page}");
    assert!(page.contains("--at 0.7,0.1,0.1 --normal 0,0,-1"), "each place says how to get its axis");
    assert_eq!(bench.feeler(&["check", "axis.toml"]).code, DONE);
    assert_eq!(bench.feeler(&["analyze", "axis.toml"]).code, DONE);
    let json = bench.feeler(&[&asked[..], &["--hold", "--json"]].concat());
    let found: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    assert!(found["mass_kg"].as_f64().unwrap() > 5.0, "{found}");
    // The axis of the first command, which somebody may have edited, is kept.
    assert!(!bench.read("axis.toml.bak").contains("[bodies.branch-1]"));
    let crossover = |side: &str| found["phase_crossover_hz"][side].as_f64().unwrap();
    assert!(
        (crossover("axis") / crossover("arm") - 1.0).abs() < HELD_CROSSOVER
            && !found["branches"].as_array().unwrap().is_empty(),
        "{found}"
    );
    assert!(
        bench.read("axis.toml").contains("[bodies.branch-1]")
            && bench.read("axis.toml").contains("phase crossover: ")
            && bench.read("axis.toml").contains(": off by ")
    );
    assert!(found["misfit"]["trusted"].as_bool().unwrap() && found["warning"].is_null(), "{found}");
    assert!(
        bench
            .read("map.csv")
            .lines()
            .next()
            .unwrap()
            .ends_with("stable_kp_misfit,stable_ki_misfit,within_5_percent,without_axis")
    );
    assert!(
        bench.read("map.csv").lines().skip(1).all(|line| line.ends_with(",true,")),
        "{}",
        bench.read("map.csv")
    );
    for command in ["check", "analyze", "run"] {
        assert_eq!(bench.feeler(&[command, "axis.toml"]).code, DONE, "{command}");
    }
    for (asked, message) in [
        (
            vec!["--pose", "0,0", "--normal", "0,0,-1"],
            "2 joint positions for 6 joints (pan, lift, elbow, bend, swivel, roll)",
        ),
        (vec!["--pose", "0,40 deg,0,0,0,0", "--normal", "0,0,-1"], "joint `lift` at 0.698"),
        (vec!["--pose", "0,0,0,0,0,0", "--normal", "0,0,0"], "has no direction"),
        (
            vec!["--pose", "0,0,0,0,0,0", "--normal", "1,0,0", "--hold"],
            "the arm cannot move along the normal",
        ),
        (vec!["--at", "0.65,0.1,0.1", "--normal", "0,0,nan"], "--normal has a number that is not finite"),
        (
            vec!["--at", "0.65,0.1,0.1", "--normal", "0,0,-1", "--contact-stiffness", "1e15"],
            "exceeds the limits of",
        ),
        (vec!["--at", "3,0,0", "--normal", "0,0,-1"], "no pose within the joint limits brings the tool to"),
    ] {
        let said = bench.feeler(&[&["reduce", arm], &asked[..]].concat());
        assert_eq!(said.code, BAD_INPUT, "{asked:?}: {}", said.out);
        assert!(said.err.contains(message) && said.err.contains("help: "), "{asked:?}: {}", said.err);
    }
}

/// Once the axis had a light motor and no stable `ki`, although the arm has one.
#[test]
fn regress_a_hard_contact_has_a_force_bandwidth_and_says_its_stable_gains() {
    let bench = Bench::new();
    let arm = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/arms/six-joint.toml");
    let asked = [
        "reduce",
        arm.to_str().unwrap(),
        "--at",
        "0.8227,-0.3,0.1",
        "--normal",
        "0,0,-1",
        "--hold",
        "--contact-stiffness",
        "5e4",
    ];
    let said = bench.feeler(&asked);
    assert!(
        said.code == DONE && said.out.contains("stable ki at 1 kHz") && !said.out.contains("NaN"),
        "{}",
        said.out
    );
    let json = bench.feeler(&[&asked[..], &["--json"]].concat());
    let found: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    let ki = |side: &str| found["stable_ki_per_s"][side].as_f64().unwrap();
    assert!(ki("arm") > 100.0 && (ki("axis") / ki("arm") - 1.0).abs() < SHARED_CROSSOVER, "{found}");
    assert!(found["force_bandwidth_hz"].as_f64().unwrap() > 1.0, "{found}");
}

/// Tolerance of the axis's crossover if two modes share the tool. With only one of them as the tool the error
/// was 36 %.
const SHARED_CROSSOVER: f64 = 0.05;

#[test]
fn regress_bodies_join_motor_and_tool_where_modes_share_it() {
    let bench = Bench::new();
    let arm = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/arms/six-joint.toml");
    let asked = [
        "reduce",
        arm.to_str().unwrap(),
        "--at",
        "0.4,0,0.1",
        "--normal",
        "0,0,-1",
        "--hold",
        "--measure",
        "--out",
        "axis.toml",
    ];
    let said = bench.feeler(&asked);
    assert!(
        said.code == DONE
            && said.out.contains("between motor and tool")
            && said.out.contains("measured in simulation"),
        "{}",
        said.out
    );
    assert!(!said.out.contains("warning"), "{}", said.out);
    assert!(bench.read("axis.toml").contains("between = [\"branch-1\", \"tip\"]"));
    let json = bench.feeler(&[&asked[..], &["--json"]].concat());
    let found: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    for of in [&found["phase_crossover_hz"], &found["measured"]["phase_crossover_hz"]] {
        let crossover = |side: &str| of[side].as_f64().unwrap();
        assert!((crossover("axis") / crossover("arm") - 1.0).abs() < SHARED_CROSSOVER, "{of}");
    }
    for command in ["check", "analyze", "run"] {
        assert_eq!(bench.feeler(&[command, "axis.toml"]).code, DONE, "{command}");
    }
}
