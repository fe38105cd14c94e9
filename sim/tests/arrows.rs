//! Which crate may know which: `cargo metadata` against the map of ARCHITECTURE.md.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Direct dependencies within the workspace that each crate may have.
const ARROWS: &[(&str, &[&str])] = &[
    ("feeler-lanes", &[]),
    ("feeler-lti", &[]),
    ("feeler-plant", &[]),
    ("feeler-control", &["feeler-lanes", "feeler-lti"]),
    ("feeler-engine", &["feeler-lanes", "feeler-lti", "feeler-plant", "feeler-control"]),
    ("feeler-arm", &["feeler-lti"]),
    ("feeler-geometry", &["feeler-plant"]),
    ("feeler-multibody", &["feeler-plant", "feeler-engine"]),
    (
        "feeler-manipulator",
        &["feeler-plant", "feeler-control", "feeler-engine", "feeler-arm", "feeler-geometry"],
    ),
    ("feeler-analysis", &["feeler-lti", "feeler-plant", "feeler-control", "feeler-engine", "feeler-lanes"]),
    (
        "feeler-sim",
        &["feeler-lanes", "feeler-lti", "feeler-plant", "feeler-control", "feeler-engine", "feeler-analysis"],
    ),
    (
        "feeler-files",
        &[
            "feeler-plant",
            "feeler-control",
            "feeler-engine",
            "feeler-arm",
            "feeler-geometry",
            "feeler-multibody",
            "feeler-manipulator",
        ],
    ),
    (
        "feeler-studies",
        &[
            "feeler-lanes",
            "feeler-lti",
            "feeler-plant",
            "feeler-control",
            "feeler-engine",
            "feeler-analysis",
            "feeler-arm",
            "feeler-geometry",
            "feeler-multibody",
            "feeler-manipulator",
            "feeler-files",
        ],
    ),
    (
        "feeler-validation",
        &[
            "feeler-lanes",
            "feeler-lti",
            "feeler-plant",
            "feeler-control",
            "feeler-engine",
            "feeler-analysis",
            "feeler-sim",
            "feeler-files",
            "feeler-studies",
        ],
    ),
    (
        "feeler-diagnosis",
        &[
            "feeler-lanes",
            "feeler-lti",
            "feeler-plant",
            "feeler-control",
            "feeler-engine",
            "feeler-analysis",
            "feeler-sim",
            "feeler-files",
            "feeler-studies",
        ],
    ),
];

#[test]
fn truth_the_crates_know_only_what_the_map_allows() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .output()
        .unwrap();
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let names: BTreeSet<&str> = packages.iter().map(|package| package["name"].as_str().unwrap()).collect();
    let allowed: BTreeMap<&str, &[&str]> = ARROWS.iter().copied().collect();
    for package in packages {
        let name = package["name"].as_str().unwrap();
        // The binary and the benchmarks may know all libraries, and no library knows them.
        let Some(allowed) = allowed.get(name) else {
            assert!(["feeler", "feeler-benches"].contains(&name), "`{name}` is not on the map");
            continue;
        };
        for dependency in package["dependencies"].as_array().unwrap().iter().filter(|d| d["kind"].is_null()) {
            let other = dependency["name"].as_str().unwrap();
            assert!(
                !names.contains(other) || allowed.contains(&other),
                "`{name}` may not depend on `{other}`"
            );
        }
    }
}
