//! `feeler sweep` and `feeler merge`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use assert_cmd::cargo::cargo_bin;
use feeler_studies::sweep::SweepTable;

use crate::bench::{Bench, DONE, exists};

#[cfg(unix)]
pub(super) const JOB_SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/slurm/sweep.sbatch");
const SCENARIO: &str = include_str!("../../../scenarios/chatter/sustained.toml");
/// 240 variants with different structure (an integrator), timing and numbers, some of them invalid.
pub(super) const SWEEP: &str = "scenario = \"chatter.toml\"\n[axes]\n\
    \"controllers.force.kp\" = { linear = [0.2, 2.1], points = 20 }\n\
    \"controllers.force.delay\" = [\"0 ms\", \"0.4 ms\", \"1 ms\"]\n\
    \"run.integrator\" = [\"exact\", \"rk4\"]\n\
    \"run.seed\" = [1, 2]\n";

pub(super) fn project() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let shorter = SCENARIO.replace("duration = \"4 s\"", "duration = \"0.5 s\"");
    fs::write(folder.path().join("chatter.toml"), shorter).unwrap();
    let sweep = folder.path().join("sweep.toml");
    fs::write(&sweep, SWEEP).unwrap();
    (folder, sweep)
}

fn feeler(arguments: &[&str]) -> Command {
    let mut command = Command::new(cargo_bin("feeler"));
    command.args(arguments).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

pub(super) fn run(arguments: &[&str]) {
    let output = feeler(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

fn chunks(out: &Path) -> usize {
    fs::read_dir(out.join("chunks")).map_or(0, Iterator::count)
}

#[test]
fn prop_threads_shards_and_kills_leave_no_trace_in_the_bytes() {
    let (folder, sweep) = project();
    let sweep = sweep.to_str().unwrap();
    let out = |name: &str| folder.path().join(name);
    let text = |path: &Path| path.to_str().unwrap().to_owned();
    let bytes = |name: &str| fs::read(out(name).join("sweep.parquet")).unwrap();
    run(&["sweep", sweep, "--threads", "1", "--out", &text(&out("one"))]);
    let expected = bytes("one");
    run(&["sweep", sweep, "--threads", "2", "--out", &text(&out("two"))]);
    assert!(bytes("two") == expected, "two threads give other bytes than one");

    for shard in ["1/3", "3/3", "2/3"] {
        run(&["sweep", sweep, "--shard", shard, "--out", &text(&out(&format!("shard-{}", &shard[..1])))]);
    }
    let incomplete =
        feeler(&["merge", &text(&out("shard-1")), &text(&out("shard-2")), "--out", &text(&out("part"))])
            .output()
            .unwrap();
    assert_eq!(incomplete.status.code(), Some(2));
    let shards = ["shard-2", "shard-1", "shard-3"].map(|name| text(&out(name)));
    run(&["merge", &shards[0], &shards[1], &shards[2], "--out", &text(&out("merged"))]);
    assert!(bytes("merged") == expected, "merged shards give other bytes than one run");

    // The command is killed after it has written one or two more chunks.
    let killed = out("killed");
    let mut kills = 0;
    while kills < 5 {
        let before = chunks(&killed);
        let mut child = feeler(&["sweep", sweep, "--threads", "2", "--out", &text(&killed)]).spawn().unwrap();
        let started = Instant::now();
        while chunks(&killed) < before + 2
            && started.elapsed() < Duration::from_secs(60)
            && child.try_wait().unwrap().is_none()
        {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(child.try_wait().unwrap().is_none(), "the sweep ended before it could be killed five times");
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!killed.join("sweep.parquet").exists());
        kills += 1;
    }
    // A file of a process that was killed while it assembled the results.
    fs::write(killed.join("sweep.parquet.0123456789abcdef.tmp"), "PAR1").unwrap();
    run(&["sweep", sweep, "--threads", "2", "--out", &text(&killed)]);
    let names = fs::read_dir(&killed).unwrap().map(|entry| entry.unwrap().path());
    let left: Vec<PathBuf> =
        names.filter(|path| path.extension().is_some_and(|extension| extension == "tmp")).collect();
    assert!(left.is_empty(), "{left:?}");
    assert!(bytes("killed") == expected, "a sweep that was killed five times gives other bytes");
}

#[test]
fn truth_a_folder_of_another_sweep_is_refused() {
    let (folder, sweep) = project();
    let out = folder.path().join("out");
    let short = SWEEP.replace("points = 20", "points = 2");
    fs::write(&sweep, &short).unwrap();
    run(&["sweep", sweep.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    fs::write(&sweep, short.replace("2.1", "2.2")).unwrap();
    let refused =
        feeler(&["sweep", sweep.to_str().unwrap(), "--out", out.to_str().unwrap()]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("another sweep"));
}

/// The sample job script with Slurm's variables for each task of an array that begins at 5. All tasks run at
/// the same time.
#[test]
#[cfg(unix)]
fn prop_the_job_script_runs_each_part_once() {
    let (folder, sweep) = project();
    let [one, array] = ["one", "array"].map(|name| folder.path().join(name));
    run(&["sweep", sweep.to_str().unwrap(), "--out", one.to_str().unwrap()]);
    let tasks = ["5", "6", "7"].map(|task| {
        let told =
            [("SLURM_ARRAY_TASK_ID", task), ("SLURM_ARRAY_TASK_MIN", "5"), ("SLURM_ARRAY_TASK_COUNT", "3")];
        let mut command = Command::new("sh");
        command.arg(JOB_SCRIPT).args([&sweep, &array]).envs(told).env("FEELER", cargo_bin("feeler"));
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    });
    for task in tasks {
        let output = task.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    run(&["merge", array.to_str().unwrap()]);
    assert!(fs::read(one.join("sweep.parquet")).unwrap() == fs::read(array.join("sweep.parquet")).unwrap());
}

#[test]
fn truth_the_verdict_is_printed_and_written() {
    let (folder, _) = project();
    let out = folder.path().join("why");
    let scenario = folder.path().join("chatter.toml");
    let output = Command::new(cargo_bin("feeler"))
        .args(["why"])
        .arg(&scenario)
        .arg("--out")
        .arg(&out)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("The chatter is due to sampling and delay"), "{text}");
    let found: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("why.json")).unwrap()).unwrap();
    assert_eq!(found["causes"], serde_json::json!(["sampling-and-delay"]));
    assert!(found["remedies"].as_array().unwrap().len() > 2);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    // The remedy comes before the trials.
    let at = |heading: &str| page.find(heading).unwrap_or_else(|| panic!("no {heading}"));
    assert!(at("What to do") < at("What was tried") && at("What was tried") < at("What remains"));
    assert!(!page.contains("nothing to remove") && page.contains("Does not apply here: "));
}

/// The command under the pointer runs a variant with the figures of its row.
#[test]
fn truth_the_command_under_the_pointer_is_the_same_however_paths_are_typed_and_gives_the_row() {
    let bench = Bench::new();
    bench.write("chatter.toml", SCENARIO);
    let axes = "[axes]\n\"controllers.force.kp\" = { linear = [2.4, 2.5], points = 2 }\n\"run.duration\" = \
                [\"0.5 s\"]\n";
    bench.write("sweep.toml", &format!("scenario = \"chatter.toml\"\n{axes}"));
    for (typed, out) in [("sweep.toml", "one"), ("./sweep.toml", "two")] {
        assert_eq!(bench.feeler(&["sweep", typed, "--out", out]).code, DONE);
    }
    let page = bench.read("one/report.html");
    assert!(page == bench.read("two/report.html"));
    assert!(page.contains("\"command\":\"feeler run chatter.toml --as-sweep\""));
    let settings = ["--set", "controllers.force.kp=2.5", "--set", "run.duration=0.5 s"];
    let said = bench
        .feeler(&[&["run", "chatter.toml", "--as-sweep", "--json", "--out", "run"], &settings[..]].concat());
    assert_eq!(said.code, DONE, "{}", said.err);
    let summary: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    let table = SweepTable::read(&bench.path("one/sweep.parquet")).unwrap();
    let of_row = |column: &str| table.reals(column).unwrap()[1];
    assert_eq!(summary["outcome"], "chatter");
    assert_eq!(summary["peak_force_n"].as_f64(), of_row("peak_force_n"));
    assert_eq!(summary["oscillation"]["amplitude_n"].as_f64(), of_row("amplitude_n"));
    assert_eq!(summary["simulated_s"].as_f64(), of_row("simulated_s"));
}

/// A bang-bang oscillation of a position that nothing can touch. Its amplitude is a distance.
#[test]
fn truth_the_amplitude_under_the_pointer_has_the_unit_of_what_is_judged() {
    let bench = Bench::new();
    bench.write(
        "axis.toml",
        "[bodies.m]\nmass = 1.0\n[springs.guide]\nbetween = [\"ground\", \"m\"]\ndamping = 6.0\n\
         [actuators.drive]\non = \"m\"\nlimit = 5.0\n[sensors.enc]\nreads = \"m.position\"\ndelay = 0.05\n\
         [controllers.c]\nlaw = \"position\"\nreads = \"enc\"\ndrives = \"drive\"\nperiod = 0.001\n\
         reference = 0.1\n[run]\nduration = 10.0\n",
    );
    let axes = "[axes]\n\"controllers.c.kp\" = { linear = [2000.0, 3000.0], points = 2 }\n";
    bench.write("sweep.toml", &format!("scenario = \"axis.toml\"\n{axes}"));
    let said = bench.feeler(&["sweep", "sweep.toml", "--out", "out"]);
    assert_eq!(said.code, DONE, "{}", said.err);
    let table = SweepTable::read(&bench.path("out/sweep.parquet")).unwrap();
    assert!(table.reals("amplitude_n").unwrap().iter().all(|amplitude| amplitude.unwrap() > 1e-3));
    let page = bench.read("out/report.html");
    let (_, column) = page.split_once("[\"amplitude\",").unwrap();
    let (column, _) = column.split_once("[\"impacts per period\"").unwrap();
    assert!(column.ends_with("\"m\"],"), "{column}");
}

#[test]
fn truth_limit_cycles_through_saturation_stand_beside_theory_and_nothing_empty_is_drawn() {
    let bench = Bench::new();
    let saturation = include_str!("../../../scenarios/chatter/saturation.toml");
    let machines = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/paper/machines");
    bench.write("saturation.toml", &saturation.replace("../paper/machines", machines));
    bench.write(
        "sweep.toml",
        "scenario = \"saturation.toml\"\n[axes]\n\"controllers.force.kp\" = { linear \
                               = [0.7, 0.8], points = 2 }\n",
    );
    let said = bench.feeler(&["sweep", "sweep.toml", "--out", "out"]);
    assert_eq!(said.code, DONE, "{}", said.err);
    let page = bench.read("out/report.html");
    assert!(page.contains("0.0 % settle, 100.0 % oscillate between limits."));
    assert!(page.contains("Theory beside it") && page.contains("predict a cycle for 2 variants"));
    assert!(!exists(bench.path("out/impacts.svg")), "no impacts, no drawing of them");
    assert!(bench.read("out/strobe.svg").contains("clip-path"), "the predicted cycle is drawn");
}

/// One of two gains settles, and the page reports that its diagram is empty. Over two numerical axes the page
/// names the sweeps that have diagrams.
#[test]
fn regress_what_is_not_drawn_is_said() {
    let bench = Bench::new();
    bench.write("chatter.toml", &SCENARIO.replace("duration = \"4 s\"", "duration = \"0.5 s\""));
    let sweep = |axes: &str| format!("scenario = \"chatter.toml\"\n[axes]\n{axes}\n");
    bench.write(
        "lists.toml",
        &sweep(
            "\"controllers.force.kp\" = [0.3, 1.2]\n\"contacts.tool.gap\" = { linear = [\"3 mm\", \"4 \
                mm\"], points = 2 }",
        ),
    );
    assert_eq!(bench.feeler(&["sweep", "lists.toml", "--out", "lists"]).code, DONE);
    let page = bench.read("lists/report.html");
    assert!(exists(bench.path("lists/amplitude-2.svg")) && !exists(bench.path("lists/amplitude-1.svg")));
    assert!(exists(bench.path("lists/impacts-2.svg")), "a list beside the axis takes no diagram away");
    assert!(page.contains("Size of the oscillation, controllers.force.kp = 0.3. No variant here has any"));
    let two = "\"controllers.force.kp\" = { linear = [0.3, 1.2], points = 2, tolerance = 0.5 }\n\
        \"contacts.tool.gap\" = { linear = [\"3 mm\", \"4 mm\"], points = 2, tolerance = \"1 mm\" \
        }\n[refine]";
    bench.write("two.toml", &sweep(two));
    let said = bench.feeler(&["sweep", "two.toml", "--out", "two"]);
    assert!(
        said.code == DONE && said.out.contains("The edge is that of this seed"),
        "{} {}",
        said.out,
        said.err
    );
    // The answer comes first, on terminal and page: 0.3 settles with either gap, 1.2 with none.
    let answer = said.out.lines().next().unwrap();
    assert!(answer.starts_with("It settles up to controllers.force.kp = "), "{answer}");
    let page = bench.read("two/report.html");
    assert!(page.contains(&format!("<p class=\"lead\">{answer} Of ")), "{answer}");
    assert!(
        page.contains("Bifurcation diagrams")
            && page.contains("nearest")
            && page.contains("The edge is that of this seed")
    );
}

/// Only the last of three random numbers varies enough to decide: from far below the limit of 0.90 to twice
/// the limit.
#[test]
fn truth_maps_of_random_numbers_are_over_those_that_decide() {
    let (folder, sweep) = project();
    let text = "scenario = \"chatter.toml\"\nsampling = \"sobol\"\nsamples = 64\n[axes]\n\
                \"bodies.tip.mass\" = { uniform = [\"4.99 kg\", \"5.01 kg\"] }\n\
                \"springs.guide.damping\" = { uniform = [\"59.9 N s/m\", \"60.1 N s/m\"] }\n\
                \"controllers.force.kp\" = { uniform = [0.1, 1.8] }\n";
    fs::write(&sweep, text).unwrap();
    let out = folder.path().join("random");
    run(&["sweep", sweep.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    let [page, map] = ["report.html", "map.svg"].map(|name| fs::read_to_string(out.join(name)).unwrap());
    assert!(map.contains("controllers.force.kp"), "the map is not over the gain");
    assert!(page.contains("controllers.force.kp matters most"));
    assert!(page.contains("over the two numbers that decide most"));
    // Each cell has its own value of one of the other numbers.
    let drawn = ["bodies.tip.mass", "springs.guide.damping"].iter().filter(|key| map.contains(**key)).count();
    assert_eq!(drawn, 1);
}
