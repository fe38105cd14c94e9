//! `feeler sweep` and `feeler merge`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use assert_cmd::cargo::cargo_bin;

const SCENARIO: &str = include_str!("../../../scenarios/chatter/sustained.toml");
/// 240 variants over structure (an integrator), timing and numbers, some of them impossible.
const SWEEP: &str = "scenario = \"chatter.toml\"\n[axes]\n\
    \"controllers.force.kp\" = { linear = [0.2, 2.1], points = 20 }\n\
    \"controllers.force.delay\" = [\"0 ms\", \"0.4 ms\", \"1 ms\"]\n\
    \"run.integrator\" = [\"exact\", \"rk4\"]\n\
    \"run.seed\" = [1, 2]\n";

fn project() -> (tempfile::TempDir, PathBuf) {
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

fn run(arguments: &[&str]) {
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
    let incomplete = feeler(&["merge", &text(&out("shard-1")), &text(&out("shard-2")), "--out", &text(&out("part"))]).output().unwrap();
    assert_eq!(incomplete.status.code(), Some(2));
    let shards = ["shard-2", "shard-1", "shard-3"].map(|name| text(&out(name)));
    run(&["merge", &shards[0], &shards[1], &shards[2], "--out", &text(&out("merged"))]);
    assert!(bytes("merged") == expected, "merged shards give other bytes than one run");

    // Killed as soon as it has written another chunk or two.
    let killed = out("killed");
    let mut kills = 0;
    while kills < 5 {
        let before = chunks(&killed);
        let mut child = feeler(&["sweep", sweep, "--threads", "2", "--out", &text(&killed)]).spawn().unwrap();
        let started = Instant::now();
        while chunks(&killed) < before + 2 && started.elapsed() < Duration::from_secs(60) && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(child.try_wait().unwrap().is_none(), "the sweep ended before it could be killed five times");
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!killed.join("sweep.parquet").exists());
        kills += 1;
    }
    run(&["sweep", sweep, "--threads", "2", "--out", &text(&killed)]);
    assert!(bytes("killed") == expected, "a sweep that was killed five times gives other bytes");
}

#[test]
fn truth_a_folder_of_another_sweep_is_refused() {
    let (folder, sweep) = project();
    let out = folder.path().join("out");
    let short = SWEEP.replace("points = 20", "points = 1");
    fs::write(&sweep, &short).unwrap();
    run(&["sweep", sweep.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    fs::write(&sweep, short.replace("2.1", "2.2")).unwrap();
    let refused = feeler(&["sweep", sweep.to_str().unwrap(), "--out", out.to_str().unwrap()]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("another sweep"));
}
