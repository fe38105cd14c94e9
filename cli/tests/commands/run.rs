//! `feeler run`.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::bench::{BAD_INPUT, Bench, DONE, PRESS, exists};
use crate::live::{data_of, values};

/// Removes the lines with times and rounding errors, which depend on the computer.
fn without_times(text: &str) -> String {
    let keep = |line: &&str| !line.contains(" steps in ") && !line.contains("energy balance");
    text.lines().filter(keep).collect::<Vec<_>>().join("\n")
}

pub(crate) fn summary(bench: &Bench, folder: &str) -> Value {
    serde_json::from_str(&bench.read(&format!("{folder}/summary.json"))).unwrap()
}

#[test]
fn truth_a_run_prints_its_summary_and_says_what_it_wrote() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let said = bench.feeler(&["run", "press.toml", "--csv"]);
    assert_eq!((said.code, said.err.as_str()), (DONE, ""));
    insta::assert_snapshot!(without_times(&said.out));
    for name in ["trace.parquet", "trace.csv", "summary.json", "report.html"] {
        assert!(exists(bench.path("out/press").join(name)), "{name}");
    }
}

#[test]
fn truth_the_summary_has_the_keys_of_the_contract() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    assert_eq!(bench.feeler(&["run", "press.toml", "--out", "here"]).code, DONE);
    let summary = summary(&bench, "here");
    for key in [
        "peak_force_n",
        "bounces",
        "settling_time_s",
        "contact_share",
        "outcome",
        "events",
        "energy",
        "steps",
        "wall_s",
    ] {
        assert!(!summary[key].is_null(), "{key}");
    }
    assert_eq!(summary["outcome"], "settled");
    let event = &summary["events"][0];
    assert_eq!((&event["what"], &event["on"]), (&Value::from("touch"), &Value::from("tool")));
    assert!(event["t_s"].as_f64().unwrap() > 0.0);
    // The energy balance is exact up to rounding errors.
    assert!(summary["energy"]["relative_residual"].as_f64().unwrap() < 1e-9);
}

#[test]
fn truth_json_on_standard_output_is_the_summary() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let said = bench.feeler(&["run", "press.toml", "--json"]);
    let printed: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(printed, summary(&bench, "out/press"));
}

#[test]
fn truth_the_csv_holds_the_recorded_signals_at_their_rate() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    bench.feeler(&["run", "press.toml", "--csv"]);
    let csv = bench.read("out/press/trace.csv");
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("t_s,tool.force,tip.position,drive.command,force.reading"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    // 0.5 s at 1 kHz, both ends included.
    assert_eq!(rows.len(), 501);
    for (row, values) in rows.iter().enumerate() {
        assert_eq!(values.len(), 5);
        assert!((values[0] - row as f64 * 1e-3).abs() < 1e-12);
    }
    assert!((rows[500][1] - 10.0).abs() < 0.2, "the force settles within 2 %");
}

#[test]
fn prop_the_same_file_gives_the_same_bytes_whatever_the_threads() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let noisy = ["--set", "sensors.force.noise=0.2", "--csv"];
    for (folder, threads) in [("a", "1"), ("b", "1"), ("c", "4")] {
        let said = bench
            .feeler(&[&["run", "press.toml", "--out", folder, "--threads", threads], &noisy[..]].concat());
        assert_eq!(said.code, DONE, "{}", said.err);
    }
    for name in ["trace.parquet", "trace.csv", "report.html"] {
        let bytes = |folder: &str| std::fs::read(bench.path(folder).join(name)).unwrap();
        assert!(bytes("a") == bytes("b") && bytes("a") == bytes("c"), "{name}");
    }
    let timeless = |folder: &str| {
        let mut summary = summary(&bench, folder);
        summary["wall_s"].take();
        summary
    };
    assert_eq!(timeless("a"), timeless("b"));
    assert_eq!(timeless("a"), timeless("c"));
}

#[test]
fn truth_settings_and_the_integrator_take_effect() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let peak = |arguments: &[&str]| {
        let said = bench.feeler(&[&["run", "press.toml", "--json"], arguments].concat());
        let summary: Value = serde_json::from_str(&said.out).unwrap();
        (summary["peak_force_n"].as_f64().unwrap(), summary["steps"].as_u64().unwrap())
    };
    let (plain, steps) = peak(&[]);
    let (hard, _) = peak(&["--set", "controllers.force.reference=20.0"]);
    assert!(hard > 1.2 * plain, "{hard} {plain}");
    let (stepped, fixed_steps) = peak(&["--integrator", "rk4", "--set", "run.step=20 us"]);
    assert!(fixed_steps > steps);
    assert!((stepped / plain - 1.0).abs() < 0.01, "{stepped} {plain}");
}

#[test]
fn truth_a_page_carries_all_it_needs() {
    let bench = Bench::new();
    bench.write("press.toml", &PRESS.replace("that damps", "that damps <b>much</b>"));
    bench.feeler(&["run", "press.toml"]);
    let page = bench.read("out/press/report.html");
    assert!(page.len() < 3 << 20, "{}", page.len());
    assert!(!page.contains("src=") && !page.contains("<link") && !page.contains("@import"));
    assert!(page.contains("&lt;b&gt;much") && !page.contains("<b>much"));
    assert!(page.contains("The force settles") && page.contains("MIT"));
}

#[test]
fn truth_chatter_is_told_in_words() {
    let bench = Bench::new();
    assert_eq!(bench.feeler(&["new", "chatter", "--out", "chatter.toml"]).code, DONE);
    let said = bench.feeler(&[
        "run",
        "chatter.toml",
        "--set",
        "controllers.force.kp=1.0",
        "--set",
        "controllers.force.ki=0",
    ]);
    assert!(said.out.starts_with("chatter: The tool chatters at "), "{}", said.out);
    let summary = summary(&bench, "out/chatter,controllers.force.kp=1.0,controllers.force.ki=0");
    assert_eq!(summary["outcome"], "chatter");
    let oscillation = &summary["oscillation"];
    assert!(oscillation["frequency_hz"].as_f64().unwrap() > 1.0);
    assert!(oscillation["contact_share"].as_f64().unwrap() < 1.0);
}

#[test]
fn truth_a_missing_file_is_one_clear_error() {
    let said = Bench::new().feeler(&["run", "nowhere.toml"]);
    assert_eq!((said.code, said.out.as_str()), (BAD_INPUT, ""));
    insta::assert_snapshot!(said.err);
}

#[test]
fn truth_a_wrong_key_on_the_command_line_is_refused() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let said = bench.feeler(&["run", "press.toml", "--set", "controllers.farce.kp=1"]);
    assert_eq!(said.code, BAD_INPUT);
    insta::assert_snapshot!(said.err);
    assert!(!exists(bench.path("out")));
}

#[test]
fn truth_mistakes_of_settings_and_file_are_told_together() {
    let bench = Bench::new();
    bench.write("press.toml", &PRESS.replace("\"2 kg\"", "-2"));
    let settings = ["run.duration=-1", "=3", "controllers.farce.kp=1", "run.record=[]"];
    let arguments: Vec<&str> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let said = bench.feeler(&[&["run", "press.toml"], arguments.as_slice()].concat());
    assert_eq!(said.code, BAD_INPUT);
    insta::assert_snapshot!(said.err);
}

#[test]
#[cfg(unix)]
fn regress_what_has_no_end_is_not_read_to_the_end() {
    let bench = Bench::new();
    assert!(bench.feeler(&["check", "/dev/zero"]).err.contains("it has more than 16777216 bytes"));
}

#[test]
fn regress_a_name_does_not_steer_the_terminal() {
    let bench = Bench::new();
    bench.write("press.toml", &PRESS.replace("name  = \"press\"", "name = \"pr\\u001b[31mess\""));
    let said = bench.feeler(&["run", "press.toml"]);
    assert!(said.out.starts_with("pr\u{fffd}[31mess: "), "{}", said.out);
}

#[test]
fn truth_a_folder_that_cannot_be_made_is_one_clear_error() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    bench.write("taken", "a file");
    let said = bench.feeler(&["run", "press.toml", "--out", "taken/inside"]);
    assert_eq!(said.code, BAD_INPUT);
    assert_eq!(
        said.err,
        "error: cannot write taken/inside: taken is a file, not a folder\n  help: name another folder with \
         --out\n"
    );
    let said = bench.feeler(&["run", "press.toml", "--out", "taken"]);
    assert!(
        said.err.starts_with("error: cannot write taken: taken is a file, not a folder\n"),
        "{}",
        said.err
    );
}

/// A command that ends with its test.
#[cfg(unix)]
struct Watching(std::process::Child);

#[cfg(unix)]
impl Drop for Watching {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
#[cfg(unix)]
fn truth_a_watched_file_is_run_again_after_every_change_until_it_is_ended() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let child = Command::new(env!("CARGO_BIN_EXE_feeler"))
        .current_dir(bench.path(""))
        .args(["run", "press.toml", "--watch", "--out", "out"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn();
    let mut child = Watching(child.unwrap());
    let mut lines = BufReader::new(child.0.stderr.take().unwrap()).lines().map(Result::unwrap);
    // Lines printed before the next wait for a change.
    let mut waits = || lines.by_ref().take_while(|line| !line.contains("watching")).collect::<Vec<_>>();
    let reference = || summary(&bench, "out")["response"]["final_reference_n"].as_f64().unwrap();
    assert_eq!(waits(), Vec::<String>::new());
    assert!((reference() - 10.0).abs() < 1e-12);
    bench.write("press.toml", &PRESS.replace("reference    = 10.0", "reference    = 12.0"));
    assert_eq!(waits(), Vec::<String>::new());
    assert!((reference() - 12.0).abs() < 1e-12);
    // A mistake in the file does not end the command.
    bench.write("press.toml", &PRESS.replace("\"2 kg\"", "-2"));
    assert!(waits().iter().any(|line| line.contains("bodies.tip.mass")));
    // A process started in the background may ignore an interrupt.
    let interrupt = Command::new("kill").args(["-TERM", &child.0.id().to_string()]).status().unwrap();
    assert!(interrupt.success() && !child.0.wait().unwrap().success());
}

/// The run is undecided because of 400 ms in place of 0.4 ms, so a longer run would not help.
#[test]
fn truth_the_probable_reason_of_an_undecided_run_comes_first() {
    let bench = Bench::new();
    assert_eq!(bench.feeler(&["new", "flexible", "--out", "flexible.toml"]).code, DONE);
    let slip = ["run", "flexible.toml", "--set", "controllers.force.delay=0.4", "--out", "out"];
    let said = bench.feeler(&slip);
    let first = "flexible: Undecided. Probable reason: a delay of 400 ms";
    assert!(said.out.starts_with(first), "{}", said.out);
    let longer = said.out.find("If that is meant: ").unwrap();
    assert!(said.out[longer..].contains("lengthen run.duration"), "{}", said.out);
    assert!(bench.read("out/report.html").contains("Undecided. Probable reason: a delay of 400 ms"));
}

#[test]
fn truth_what_a_check_doubts_is_said_with_a_run_that_loses_its_contact() {
    let bench = Bench::new();
    bench.write("away.toml", &PRESS.replace("[\"tip\", \"ground\"]", "[\"ground\", \"tip\"]"));
    let doubt = "a positive command of `drive` pulls";
    assert!(bench.feeler(&["check", "away.toml"]).out.contains(doubt));
    let said = bench.feeler(&["run", "away.toml", "--out", "out"]);
    assert!(said.err.contains("warning: contacts.tool.between") && said.err.contains(doubt), "{}", said.err);
    assert!(said.out.contains("Probable reason: a positive command"), "{}", said.out);
    assert!(bench.read("out/report.html").contains("Probable reason"));
    // The tool approaches in the opposite direction.
    let encoder = "\n[sensors.encoder]\nreads = \"tip.position\"\n";
    bench.write("sent.toml", &(bench.read("away.toml") + encoder));
    let approach = "controllers.force.approach={ speed = 0.01, until = 2 }";
    let said = bench.feeler(&["run", "sent.toml", "--set", approach, "--out", "out"]);
    assert!(said.out.contains("still approaches"), "{}", said.out);
    assert!(said.out.contains("Probable reason: a positive command"), "{}", said.out);
    let pulled =
        bench.feeler(&["run", "away.toml", "--set", "contacts.tool.engagement=free", "--out", "out"]);
    assert!(pulled.out.contains("Every contact of the file is set free."), "{}", pulled.out);
    bench.write("press.toml", PRESS);
    let setting = "controllers.force.reference=[[0, 10], [0.2, -10]]";
    let pulled = bench.feeler(&["run", "press.toml", "--set", setting, "--out", "out"]);
    assert!(pulled.out.contains("does not end above zero"), "{}", pulled.out);
}

/// Once a run that ended well did not report doubts about its file. 10 N press 1 mm into 10 kN/m.
#[test]
fn regress_a_run_that_settles_prints_what_a_check_doubts_once() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let said = bench.feeler(&["run", "press.toml", "--set", "contacts.tool.gap=-1 mm", "--out", "out"]);
    assert_eq!(summary(&bench, "out")["outcome"], "settled");
    let doubt = "`tip` starts 1 mm inside `ground`: the contact begins with a push of 10 N";
    assert_eq!(said.err.matches(doubt).count(), 1, "{}", said.err);
    assert!(bench.read("out/report.html").contains("Doubtful in the file: contacts.tool.gap"));
    bench.write("forward.toml", &PRESS.replace("kp           = 0.2\n", ""));
    let said = bench.feeler(&["run", "forward.toml", "--out", "out"]);
    assert!(said.err.contains("`force` has only feed_forward"), "{}", said.err);
    assert!(bench.feeler(&["check", "forward.toml"]).out.contains("`force` has only feed_forward"));
}

#[test]
fn regress_the_keys_of_a_law_come_first_where_a_key_is_unknown() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let said = bench.feeler(&["run", "press.toml", "--set", "controllers.force.gain=2"]);
    assert_eq!(said.code, BAD_INPUT);
    assert!(said.err.contains("`kp`, `ki`, `kd`, `damping`"), "{}", said.err);
}

/// 10 N press 1 mm into a surface of 10 kN/m on average, while the surface moves up and down by 1 mm.
#[test]
fn truth_a_surface_that_moves_is_drawn_and_the_error_of_tracking_is_told() {
    let bench = Bench::new();
    let turns = (3..=10).map(|i| format!(", [{}, {}]", 0.1 * f64::from(i), f64::from(i % 2) * 1e-3));
    let offset: String = turns.collect();
    let profile = format!("[contacts.tool.profile]\noffset = [[0, 0], [0.2, 0]{offset}]\n");
    bench.write("wavy.toml", &format!("{PRESS}\n{profile}"));
    let said = bench.feeler(&["run", "wavy.toml", "--set", "run.duration=1", "--out", "out"]);
    assert_eq!(said.code, DONE, "{}", said.err);
    let summary = summary(&bench, "out");
    assert_eq!(summary["outcome"], "follows-surface");
    let error_n = |name: &str| summary["response"]["tracking"][name].as_f64().unwrap();
    let [largest, rms] = ["largest_error_n", "rms_error_n"].map(error_n);
    assert!(0.5 * largest < rms && rms < largest && largest < 2.0, "{summary}");
    for word in ["the force stays within", "tracking error", "root mean square"] {
        assert!(said.out.contains(word), "{word}: {}", said.out);
    }
    let page = data_of(&bench.read("out/report.html"));
    let mut charts = page["charts"].as_array().unwrap().iter();
    let chart = charts.find(|chart| chart["series"][0]["name"] == "surface").unwrap();
    let [surface, tip] = [0, 1].map(|i| values(&chart["series"][i]));
    let (low, high) = surface.iter().fold((f64::MAX, 0.0), |(l, h), x| (x.min(l), x.max(h)));
    assert_eq!(chart["y"]["label"], "position (mm)");
    // The cubics begin to fall by a tenth before the first rise.
    assert!((0.85..=1.0).contains(&low) && (high - 2.0).abs() < 1e-6, "{low} to {high} mm");
    let late = surface.len() * 6 / 10;
    let depths = tip.iter().zip(&surface).skip(late).map(|(tip, surface)| tip - surface);
    let depth = depths.sum::<f64>() / (surface.len() - late) as f64;
    assert!((depth - 1.0).abs() < 0.02, "{depth} mm deep");
}

#[test]
fn truth_an_undecided_run_says_where_its_force_is() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let said = bench.feeler(&["run", "press.toml", "--set", "run.duration=0.06", "--out", "out"]);
    assert!(said.out.contains("Undecided: the oscillation dies out but has not ended"), "{}", said.out);
    let summary = summary(&bench, "out");
    let mean = 10.0 + summary["response"]["steady_error_n"].as_f64().unwrap();
    let swings = summary["verdict"]["amplitudes_n"][2].as_f64().unwrap();
    // Four significant digits.
    let told =
        format!("So far the force is {mean:.2} N at the end, and oscillates by {:.1} mN", 1e3 * swings);
    assert!(said.out.contains(&told), "{told}: {}", said.out);
}
