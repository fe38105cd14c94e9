//! The promises of ARCHITECTURE.md, each checked against the repository.

#![expect(
    clippy::unwrap_used,
    reason = "a file or command of the repository that is not there fails the test"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::messages;

type Names = BTreeSet<String>;

/// Folders of the computing crates: all except the command line, the benchmarks and the examples.
pub(crate) const LIBRARIES: [&str; 7] =
    ["sim", "logs", "files", "studies", "validation", "diagnosis", "library"];

/// Modules that no crate of `sim` may use.
const OUTSIDE_WORLD: [&str; 8] = [
    "std::fs",
    "std::io",
    "std::env",
    "std::net",
    "std::process",
    "std::thread",
    "Instant::now",
    "SystemTime",
];

/// Code that starts a thread without rayon.
const THREADS: [&str; 2] = ["thread::scope", "thread::spawn"];

/// Code that prints.
const PRINTS: [&str; 6] = ["println!(", "print!(", "eprint!(", "dbg!(", "io::stdout", "io::stderr"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The part of the page under a heading.
fn section(title: &str) -> String {
    let page = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let from = page.find(&format!("\n## {title}\n")).unwrap_or_else(|| panic!("no section `{title}`")) + 5;
    let rest = &page[from + title.len()..];
    rest[..rest.find("\n## ").unwrap_or(rest.len())].to_owned()
}

/// Words between back-ticks.
fn quoted(text: &str) -> Vec<String> {
    text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Adds all crates that a crate reaches by arrows.
fn below(name: &str, direct: &BTreeMap<String, (Names, String)>, found: &mut Names) {
    for other in &direct.get(name).unwrap_or_else(|| panic!("`{name}` has no arrows")).0 {
        if found.insert(other.clone()) {
            below(other, direct, found);
        }
    }
}

/// The arrows of each crate, from the first paragraph of their section: the crates that it names, and its
/// words.
fn arrows() -> BTreeMap<String, (Names, String)> {
    let section = section("Arrows");
    let paragraph = section.trim().split("\n\n").next().unwrap();
    let mut direct = BTreeMap::new();
    for clause in paragraph.trim_end_matches('.').split(';') {
        let (from, to) = clause.split_once("->").unwrap_or((clause, ""));
        for name in quoted(from) {
            direct.insert(name, (quoted(to).into_iter().collect(), to.to_owned()));
        }
    }
    direct
}

/// The allowed dependencies of each crate.
fn allowed() -> BTreeMap<String, Names> {
    let direct = arrows();
    let all: Names = direct.keys().cloned().collect();
    let of = |(name, (others, words)): (&String, &(Names, String))| {
        let mut found = others.clone();
        if words.contains("everything") {
            found = all.difference(others).cloned().collect();
            found.remove(name);
        } else if words.contains("and below") {
            found = Names::new();
            below(name, &direct, &mut found);
        }
        (name.clone(), found)
    };
    direct.iter().map(of).collect()
}

/// The packages of the workspace by the names of their folders, with `cargo`'s metadata.
fn packages() -> BTreeMap<String, Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .output()
        .unwrap();
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap().iter();
    let folder = |package: &Value| {
        let manifest = Path::new(package["manifest_path"].as_str().unwrap()).to_owned();
        manifest.parent().unwrap().file_name().unwrap().to_str().unwrap().to_owned()
    };
    packages.map(|package| (folder(package), package.clone())).collect()
}

/// Names of a package's dependencies, without tests.
fn dependencies(package: &Value) -> Vec<&str> {
    let all = package["dependencies"].as_array().unwrap().iter();
    all.filter(|d| d["kind"].is_null()).map(|d| d["name"].as_str().unwrap()).collect()
}

/// Rust files below a folder, each with its text without its tests.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let lines: Vec<&str> = messages::product(&text).map(|(_, line)| line).collect();
            found.push((path, lines.join("\n")));
        }
    }
    found
}

/// Product code of the crates in a folder: every `src` below it.
pub(crate) fn product(folder: &str) -> Vec<(PathBuf, String)> {
    let is_product = |path: &Path| path.components().any(|part| part.as_os_str() == "src");
    sources(&root().join(folder)).into_iter().filter(|(path, _)| is_product(path)).collect()
}

/// Fails if a file contains one of some texts.
fn refuse(files: &[(PathBuf, String)], texts: &[&str]) {
    assert!(!files.is_empty(), "no file was read");
    for (path, text) in files {
        for refused in texts {
            assert!(!text.contains(refused), "{} holds `{refused}`", path.display());
        }
    }
}

#[test]
fn truth_the_crates_know_only_what_the_page_allows() {
    let (allowed, packages) = (allowed(), packages());
    let folder_of: BTreeMap<&str, &String> =
        packages.iter().map(|(folder, package)| (package["name"].as_str().unwrap(), folder)).collect();
    assert_eq!(
        allowed.keys().collect::<Vec<_>>(),
        packages.keys().collect::<Vec<_>>(),
        "the page names other crates than there are"
    );
    let arrows = arrows();
    for (name, package) in &packages {
        let used: Names = dependencies(package)
            .into_iter()
            .filter_map(|other| folder_of.get(other).map(|folder| (*folder).clone()))
            .collect();
        let beyond: Vec<_> = used.difference(&allowed[name]).collect();
        assert!(beyond.is_empty(), "`{name}` may not depend on {beyond:?}");
        let (named, words) = &arrows[name];
        let idle: Vec<_> = named.difference(&used).collect();
        let is_exception = words.contains("everything");
        assert!(is_exception || idle.is_empty(), "`{name}` does not depend on {idle:?}, as the page says");
    }
}

/// For the parser: a missed arrow would allow nothing, a misread one too much.
#[test]
fn truth_arrows_are_read_as_they_are_written() {
    let allowed = allowed();
    let of = |name: &str| allowed[name].iter().map(String::as_str).collect::<Vec<_>>();
    assert_eq!(of("lanes"), [""; 0]);
    assert_eq!(of("control"), ["catalogue", "lanes", "problem"]);
    assert!(of("diagnosis").contains(&"plant") && !of("diagnosis").contains(&"validation"));
    assert!(!of("library").contains(&"cli") && of("cli").contains(&"validation"));
}

/// Every test program is linked separately, and the next one waits for its slowest test.
#[test]
fn truth_the_integration_tests_of_a_crate_are_one_program() {
    for (name, package) in packages() {
        let targets = package["targets"].as_array().unwrap().iter();
        let programs = targets.filter(|target| target["kind"][0] == "test").count();
        assert!(programs <= 1, "`{name}` has {programs} programs of tests; make them modules of one");
    }
}

#[test]
fn truth_the_library_has_every_crate_below_it() {
    let text = fs::read_to_string(root().join("library/src/lib.rs")).unwrap();
    let parts = text.lines().filter_map(|line| line.strip_prefix("pub use feeler_")?.split_once(" as "));
    let parts: Names = parts.map(|(name, _)| name.to_owned()).collect();
    assert_eq!(parts, allowed()["library"]);
}

#[test]
fn truth_the_map_has_every_crate_and_no_folder_that_is_not_there() {
    let page = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let map = page.split("```").nth(1).unwrap();
    let mut parent = PathBuf::new();
    let mut named = Names::new();
    for line in map.lines() {
        let indent = line.len() - line.trim_start().len();
        let word = line.split_whitespace().next().unwrap_or_default();
        // A deeper indentation continues a remark.
        if indent > 2 || !word.ends_with('/') {
            continue;
        }
        let path = if indent == 0 { PathBuf::from(word) } else { parent.join(word) };
        assert!(root().join(&path).is_dir(), "there is no folder {}", path.display());
        if indent == 0 {
            parent = path;
        }
        named.insert(word.trim_end_matches('/').to_owned());
    }
    for name in packages().keys() {
        assert!(named.contains(name), "the map lacks the crate `{name}`");
    }
}

#[test]
fn truth_the_simulator_touches_no_files_clock_or_threads() {
    refuse(&product("sim"), &OUTSIDE_WORLD);
}

#[test]
fn truth_threads_are_started_only_where_the_page_says() {
    let section = section("Invariants");
    let promise = section.split("\n- ").find(|promise| promise.contains("rayon")).unwrap();
    let sentence = promise.split('.').next().unwrap();
    let named: Names = quoted(sentence).into_iter().collect();
    let packages = packages();
    let users = packages.iter().filter(|(_, package)| dependencies(package).contains(&"rayon"));
    let users: Names = users.map(|(name, _)| name.clone()).collect();
    assert_eq!(named, users);
    for folder in LIBRARIES {
        refuse(&product(folder), &THREADS);
    }
}

#[test]
fn truth_the_command_line_starts_threads_only_to_write_compare_and_serve() {
    let files = product("cli/src");
    let starts = |text: &str| text.contains("rayon::") || THREADS.iter().any(|start| text.contains(start));
    let users = files.iter().filter(|(_, text)| starts(text));
    let users: Names = users
        .map(|(path, _)| path.display().to_string().rsplit_once("cli/src/").unwrap().1.to_owned())
        .collect();
    let named = [
        "commands/compare.rs",
        "commands/run.rs",
        "live/mod.rs",
        "live/session.rs",
        "pages/sweep/png/mod.rs",
        "terminal/failure.rs",
    ];
    assert_eq!(users, named.map(str::to_owned).into());
}

#[test]
fn truth_only_the_command_line_prints() {
    for folder in LIBRARIES {
        refuse(&product(folder), &PRINTS);
    }
}

#[test]
fn truth_pages_know_no_commands_and_start_no_computation() {
    refuse(&product("cli/src/pages"), &["commands::", "linear_limits", "predicted_cycles", "diagnose("]);
}

#[test]
fn truth_effects_know_no_controller() {
    assert!(!allowed()["plant"].contains("control"), "effects are in `plant`");
    refuse(&product("sim/plant/src/effects"), &["ControllerSpec", "ControllerUse", "feeler_control"]);
}

#[test]
fn truth_the_diagnosis_sees_no_truth_and_the_bench_no_simulator() {
    let all = product("diagnosis");
    let (bench, own): (Vec<_>, Vec<_>) =
        all.into_iter().partition(|(path, _)| path.components().any(|part| part.as_os_str() == "blind"));
    // The front page of the crate names its modules.
    let own: Vec<_> = own.into_iter().filter(|(path, _)| !path.ends_with("src/lib.rs")).collect();
    refuse(&own, &["blind::"]);
    // The plain regression reads machines and records through the common code, and fits by its own method.
    let (regression, bench): (Vec<_>, Vec<_>) = bench
        .into_iter()
        .partition(|(path, _)| path.components().any(|part| part.as_os_str() == "regression"));
    refuse(&bench, &["feeler_", "crate::"]);
    let solvers = ["feeler_engine", "feeler_analysis", "feeler_lti", "feeler_studies"];
    refuse(&regression, &solvers);
    let own =
        ["crate::fit", "crate::predict", "crate::gap", "crate::kinds", "crate::adequacy", "crate::inverse"];
    refuse(&regression, &own);
}

#[test]
fn truth_a_program_is_not_changed_while_it_runs() {
    refuse(&product("sim/engine/src"), &["&mut Program", "&mut Scenario"]);
}

/// Files of the computing crates whose product code has a text.
fn with(text: &str) -> Vec<String> {
    let all = LIBRARIES.iter().flat_map(|folder| product(folder));
    let found = all.filter(|(_, source)| source.contains(text));
    let name = |path: PathBuf| path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned();
    let mut names: Vec<String> = found.map(|(path, _)| name(path)).collect();
    names.sort();
    names
}

#[test]
fn truth_one_sampler_serves_every_clock_and_one_rule_follows_targets() {
    let [controllers, servos, arm] = [
        "sim/engine/src/sample/control_loop.rs",
        "sim/engine/src/sample/servo_loop.rs",
        "sim/manipulator/src/sampling.rs",
    ];
    assert_eq!(with("Sampler::new("), [controllers, servos, arm]);
    let [control, sampler] = ["sim/control/src/controller.rs", "sim/engine/src/sample/sampler.rs"];
    // The predictor alone has instants of its own.
    let predicted = "diagnosis/src/predict/loops.rs";
    assert_eq!(with(".sample_fed("), [predicted, control, sampler]);
    assert_eq!(with(".controller.sample("), [predicted]);
    assert_eq!(with("fn follow<"), [servos]);
    assert_eq!(with("use feeler_engine::parts::follow;"), [predicted]);
}

/// The crate of a file, as the arrows name it.
fn crate_of(path: &str) -> String {
    let mut parts = path.split('/');
    let first = parts.next().unwrap();
    if first == "sim" { parts.next().unwrap().to_owned() } else { first.to_owned() }
}

#[test]
fn truth_every_step_of_the_ways_exists_and_none_leads_back_up() {
    let (section, allowed) = (section("Three ways through the house"), allowed());
    let ways: Vec<&str> = section.split("```").skip(1).step_by(2).collect();
    assert_eq!(ways.len(), 3);
    for way in ways {
        let files: Vec<&str> = way
            .lines()
            .filter_map(|line| line.split_whitespace().next())
            .filter(|w| w.contains('/'))
            .collect();
        assert!(files.len() > 3, "{way}");
        for file in &files {
            assert!(root().join(file).is_file(), "there is no {file}");
        }
        for (file, crate_name) in files.iter().map(|file| (file, crate_of(file))) {
            let source = fs::read_to_string(root().join(file)).unwrap();
            for (other, below) in &allowed {
                let knows_it = source.contains(&format!("feeler_{}::", other.replace('-', "_")));
                let is_above = below.contains(&crate_name);
                assert!(!(knows_it && is_above), "{file} knows `{other}`, which is above it");
            }
        }
    }
}

/// A promise may name the tests that hold it.
#[test]
fn truth_every_test_that_the_page_names_exists() {
    let page = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let kinds = ["truth_", "prop_", "order_", "reference_", "regress_"];
    let named: Vec<String> =
        quoted(&page).into_iter().filter(|word| kinds.iter().any(|kind| word.starts_with(kind))).collect();
    assert!(!named.is_empty(), "the page names no test");
    let whole: Vec<String> = ["sim", "files", "studies", "diagnosis", "cli", "library", "validation"]
        .iter()
        .flat_map(|folder| texts(&root().join(folder)))
        .collect();
    for name in named {
        let test = format!("fn {name}(");
        assert!(whole.iter().any(|text| text.contains(&test)), "no test `{name}`");
    }
}

/// Outside of the drawn ways and the map, a quoted word with a slash is a path.
#[test]
fn truth_every_path_that_the_prose_names_exists() {
    let page = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let prose: String = page.split("```").step_by(2).collect();
    let paths: Vec<String> = quoted(&prose).into_iter().filter(|word| word.contains('/')).collect();
    assert!(paths.len() > 3, "{paths:?}");
    for path in paths {
        assert!(root().join(&path).exists(), "there is no {path}");
    }
}

/// Every Rust file below a folder, whole.
fn texts(folder: &Path) -> Vec<String> {
    sources(folder).into_iter().map(|(path, _)| fs::read_to_string(path).unwrap()).collect()
}
