//! `feeler live`, without a browser; `.ci/browser` opens its page.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::bench::{Bench, DONE, PRESS, exists};
use crate::diagnose::{AXIS, records};

/// A running server, which ends with its test.
struct Served {
    child: Child,
    host: String,
    secret: String,
}

impl Served {
    fn new(bench: &Bench, arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_feeler"))
            .current_dir(bench.path(""))
            .arg("live")
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut address = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
        let (host, secret) = address.trim().strip_prefix("http://").unwrap().split_once('/').unwrap();
        Self { child, host: host.to_owned(), secret: secret.trim_end_matches('/').to_owned() }
    }

    /// Status and body of an answer.
    fn ask(&self, method: &str, path: &str, host: &str, body: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        let length = body.len();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: {host}\r\nContent-Length: {length}\r\n\
             Connection: close\r\n\r\n{body}"
        )
        .unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        let status = text.split(' ').nth(1).unwrap().parse().unwrap();
        (status, text.split_once("\r\n\r\n").map(|(_, body)| body.to_owned()).unwrap_or_default())
    }

    fn post(&self, path: &str, body: &Value) -> Value {
        let (status, text) =
            self.ask("POST", &format!("/{}/{path}", self.secret), &self.host, &body.to_string());
        assert_eq!(status, 200, "{text}");
        // A response may be chunked, with the length before each chunk.
        let text = text.find('{').zip(text.rfind('}')).map(|(from, to)| &text[from..=to]).unwrap();
        let whole: String =
            text.split("\r\n").filter(|line| usize::from_str_radix(line, 16).is_err()).collect();
        serde_json::from_str(&whole).unwrap_or_else(|error| panic!("{error}: {whole}"))
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn truth_only_the_secret_path_of_the_loopback_address_is_answered() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let served = Served::new(&bench, &["press.toml", "--port", "0"]);
    assert!(served.host.starts_with("127.0.0.1:") && served.secret.len() == 32, "{}", served.host);
    let own = format!("/{}/", served.secret);
    let status = |path: &str, host: &str| served.ask("GET", path, host, "").0;
    assert_eq!(status(&own, &served.host), 200);
    let guess = format!("/{}/", "0".repeat(32));
    let other = format!("{own}../press.toml");
    for path in ["/", "/press.toml", guess.as_str(), other.as_str()] {
        assert_eq!(status(path, &served.host), 404, "{path}");
    }
    // A foreign host name that resolves to this computer is refused.
    assert_eq!(status(&own, "attacker.example"), 404);
    assert_eq!(status(&own, &format!("{}\r\nHost: attacker.example", served.host)), 404);
}

#[test]
fn truth_a_number_that_is_moved_moves_what_follows_and_is_written_with_its_comments() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let served = Served::new(&bench, &["press.toml"]);
    let state = |kp: f64| served.post("state", &json!({ "settings": { "controllers.force.kp": kp } }));
    let (calm, wild) = (state(0.05), state(40.0));
    for chart in ["force", "drive", "step", "magnitude", "phase"] {
        assert!(calm["charts"][chart]["series"][0]["values"].is_object(), "{chart}");
    }
    assert!(calm["planes"]["nyquist"].is_object() && calm["planes"]["locus"].is_object());
    // The page requests run and theory separately, and gets the same results.
    let part = |part: &str| {
        served.post("state", &json!({ "settings": { "controllers.force.kp": 0.05 }, "part": part }))
    };
    let [run, theory] = ["run", "theory"].map(part);
    for (part, charts) in [(&run, &["force", "drive"][..]), (&theory, &["step", "magnitude", "phase"])] {
        let own: Vec<&str> = part["charts"].as_object().unwrap().keys().map(String::as_str).collect();
        assert!(own.len() == charts.len() && charts.iter().all(|name| own.contains(name)), "{own:?}");
        assert!(own.iter().all(|name| part["charts"][name] == calm["charts"][name]));
    }
    assert_eq!(theory["planes"], calm["planes"]);
    let lead = [&run, &theory].map(|part| part["lead"].as_str().unwrap()).join(" ");
    assert_eq!(calm["lead"], lead);
    assert_ne!(calm["lead"], wild["lead"]);
    assert_eq!(calm["stable"], wild["stable"], "stable gains do not depend on the gain");
    assert!(wild["lead"].as_str().unwrap().contains("unstable"), "{}", wild["lead"]);
    let brief = served.post("state", &json!({ "settings": { "run.duration": 0.02 } }));
    assert!(brief["lead"].as_str().unwrap().starts_with("Undecided"), "{}", brief["lead"]);
    let (_, listed) = served.ask("GET", &format!("/{}/file", served.secret), &served.host, "");
    assert!(listed.contains("\"run.duration\"") && !listed.contains("run.record_rate"), "{listed}");
    let refused = served.post("state", &json!({ "settings": { "bodies.tip.mass": -1.0 } }));
    assert!(refused["problem"].as_str().unwrap().contains("bodies.tip.mass"), "{refused}");

    let keys = json!({ "x": "controllers.force.kp", "y": "bodies.tip.mass" });
    let map = json!({ "settings": {}, "keys": keys, "points": [[0.05, 2.0], [40.0, 2.0], [0.05, -1.0]] });
    let outcomes = served.post("map", &map)["outcomes"].clone();
    assert_eq!(outcomes[0], calm["outcome"]);
    assert!(outcomes[1] != outcomes[0] && outcomes[2].is_null(), "{outcomes}");

    for same in [json!({}), json!({ "bodies.tip.mass": 2.0 })] {
        let idle = served.post("write", &json!({ "settings": same }));
        assert_eq!(idle, json!({ "written": null }));
        assert!(bench.read("press.toml") == PRESS && !exists(bench.path("press.toml.bak")));
    }
    let written = served.post("write", &json!({ "settings": { "bodies.tip.mass": 2.5 } }));
    assert!(written["problem"].is_null(), "{written}");
    assert_eq!(bench.read("press.toml.bak"), PRESS);
    let now = bench.read("press.toml");
    assert!(now != PRESS && now.lines().count() == PRESS.lines().count(), "{now}");
    let checked = bench.feeler(&["check", "press.toml"]);
    assert_eq!(checked.code, DONE, "{}", checked.err);
}

#[test]
fn truth_what_was_set_is_written_too_and_what_an_editor_saved_stays() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let served = Served::new(&bench, &["press.toml", "--set", "controllers.force.kp=0.3"]);
    let refused = served.post("write", &json!({ "settings": { "bodies.tip.mass": -1.0 } }));
    assert!(refused["problem"].as_str().unwrap().contains("bodies.tip.mass"), "{refused}");
    assert!(bench.read("press.toml") == PRESS && !exists(bench.path("press.toml.bak")));
    // The file is saved between two requests of the page.
    let saved = PRESS.replace("\"1 mm\"", "\"2 mm\"");
    bench.write("press.toml", &saved);
    let written = served.post("write", &json!({ "settings": { "bodies.tip.mass": 2.5 } }));
    assert!(written["problem"].is_null(), "{written}");
    assert_eq!(bench.read("press.toml.bak"), saved);
    let expected = saved.replace("\"2 kg\"", "\"2.5 kg\"").replace("= 0.2\n", "= 0.3\n");
    assert_eq!(bench.read("press.toml"), expected);
    // From here the value is in the file.
    bench.write("press.toml", &expected.replace("= 0.3\n", "= 0.25\n"));
    let (_, listed) = served.ask("GET", &format!("/{}/file", served.secret), &served.host, "");
    let listed: Value = serde_json::from_str(&listed).unwrap();
    let numbers = listed["numbers"].as_array().unwrap();
    let kp = numbers.iter().find(|number| number["key"] == "controllers.force.kp").unwrap();
    assert_eq!(kp["value"], 0.25);
    let broken = expected.replace("[bodies.tip]", "[bodies.tipp]");
    bench.write("press.toml", &broken);
    let refused = served.post("write", &json!({ "settings": { "bodies.tip.mass": 3.0 } }));
    assert!(refused["problem"].is_string() && bench.read("press.toml") == broken, "{refused}");
}

/// Each entry of a list has a slider. A `--set` of one entry is written too.
#[test]
fn truth_points_of_a_reference_are_moved_and_written() {
    let bench = Bench::new();
    let line = PRESS.lines().find(|line| line.starts_with("reference")).unwrap();
    let text = |points: &str| PRESS.replace(line, &format!("reference = {points}   # a step"));
    bench.write("press.toml", &text("[[0.0, \"10 N\"], [0.2, \"14 N\"]]"));
    let set = "controllers.force.reference=[[0.0, \"10 N\"], [0.2, \"16 N\"]]";
    let served = Served::new(&bench, &["press.toml", "--set", set]);
    let force = || {
        let (_, listed) = served.ask("GET", &format!("/{}/file", served.secret), &served.host, "");
        let listed: Value = serde_json::from_str(&listed).unwrap();
        let numbers = listed["numbers"].as_array().unwrap();
        let number = numbers.iter().find(|number| number["key"] == "controllers.force.reference.1.1");
        number.unwrap_or_else(|| panic!("{numbers:?}")).clone()
    };
    assert_eq!((&force()["value"], &force()["unit"]), (&json!(16.0), &json!("N")));
    let moved = json!({ "controllers.force.reference.1.0": 0.3 });
    let reference = |settings: &Value| {
        let state = served.post("state", &json!({ "settings": settings, "part": "run" }));
        let series = state["charts"]["force"]["series"].as_array().unwrap().clone();
        series.into_iter().find(|one| one["name"].as_str().unwrap().contains("reference")).unwrap()
    };
    assert_ne!(reference(&moved), reference(&json!({})));
    let late = served.post("state", &json!({ "settings": { "controllers.force.reference.0.0": 0.7 } }));
    assert!(late["problem"].as_str().unwrap().contains("controllers.force.reference"), "{late}");
    let written = served.post("write", &json!({ "settings": moved }));
    assert!(written["problem"].is_null(), "{written}");
    assert_eq!(bench.read("press.toml"), text("[[0.0, \"10 N\"], [0.3, \"16 N\"]]"));
    // From here the value is in the file.
    bench.write("press.toml", &text("[[0.0, \"10 N\"], [0.3, \"12 N\"]]"));
    assert_eq!(force()["value"], 12.0);
}

#[test]
fn truth_a_base_machine_is_watched_as_its_file_is() {
    let bench = Bench::new();
    bench.write("base.toml", PRESS);
    bench.write("child.toml", "name = \"child\"\nmachine = \"base.toml\"\n");
    let served = Served::new(&bench, &["child.toml"]);
    let file = || {
        let (_, file) = served.ask("GET", &format!("/{}/file", served.secret), &served.host, "");
        serde_json::from_str::<Value>(&file).unwrap()
    };
    let version = || file()["version"].clone();
    assert_eq!([version(), version()], [0, 0]);
    bench.write("base.toml", &PRESS.replace("= 0.2\n", "= 0.4\n"));
    assert_eq!([version(), version()], [1, 1]);
    // A mistake has its file, line, column and remedy; a wrong value has its key too.
    bench.write("base.toml", "\n[");
    let broken = file();
    assert_eq!(broken["version"], 2);
    let said = broken["problem"].as_str().unwrap();
    assert!(said.starts_with("base.toml:2:") && said.ends_with(')'), "{said}");
    bench.write("base.toml", &PRESS.replace("\"2 kg\"", "\"2 t\""));
    let said = file()["problem"].clone();
    let said = said.as_str().unwrap();
    let line = PRESS.lines().position(|line| line.contains("2 kg")).unwrap() + 1;
    assert!(
        said.starts_with(&format!("base.toml:{line}:")) && said.contains(": bodies.tip.mass: "),
        "{said}"
    );
    bench.write("base.toml", PRESS);
    assert_eq!([&file()["version"], &file()["problem"]], [&json!(4), &Value::Null]);
}

/// 600 s need 600 000 samples of the controller: no computer simulates them in the 25 ms available while a
/// slider moves.
#[test]
fn truth_a_long_run_is_cut_short_while_a_slider_moves_only() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let served = Served::new(&bench, &["press.toml"]);
    let run = |duration_s: f64, in_motion: bool| {
        let settings = json!({ "run.duration": duration_s });
        served.post("state", &json!({ "settings": settings, "part": "run", "in_motion": in_motion }))
    };
    let whole = run(600.0, false);
    let cut = run(600.0, true);
    assert_eq!([&whole["partial"], &cut["partial"]], [&json!(false), &json!(true)]);
    assert!(cut["lead"].as_str().unwrap().ends_with(" of 600 s."), "{}", cut["lead"]);
    let bytes = STANDARD.decode(cut["charts"]["force"]["x"]["values"]["f64"].as_str().unwrap()).unwrap();
    let times: Vec<f64> =
        bytes.chunks_exact(8).map(|eight| f64::from_le_bytes(eight.try_into().unwrap())).collect();
    let force = values(&cut["charts"]["force"]["series"][0]);
    let [before, end] = times[times.len() - 2..] else { panic!("{times:?}") };
    assert!((end - 600.0).abs() < 1e-9 && force[force.len() - 1].is_nan(), "the axis is that of the whole");
    // At least a tenth of the run, and never all of it.
    assert!((60.0 - 1e-3..600.0).contains(&before), "{before}");
    assert_eq!(run(600.0, false)["lead"], whole["lead"]);
    assert_eq!(run(0.02, true)["partial"], false, "a short run is shown whole");
}

/// The data from which the scripts of a page draw.
pub(crate) fn data_of(page: &str) -> Value {
    let (_, data) = page.split_once("id=\"data\">").unwrap();
    serde_json::from_str(&data.split_once("</script>").unwrap().0.replace("<\\/", "</")).unwrap()
}

/// Values of a curve of a page: the bytes of floats in base64.
pub(crate) fn values(series: &Value) -> Vec<f64> {
    let bytes = STANDARD.decode(series["values"]["f32"].as_str().unwrap()).unwrap();
    let four = bytes.chunks_exact(4).map(|four| f32::from_le_bytes(four.try_into().unwrap()));
    four.map(f64::from).collect()
}

/// Root of the mean square.
pub(crate) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

#[test]
fn truth_records_lie_over_the_machine_as_set_and_as_repaired() {
    let bench = records();
    // The friction of the recorded axis.
    bench.write("repaired.toml", &format!("{AXIS}[springs.guide.effects.coulomb-friction]\nlevel = 4.0\n"));
    let served = Served::new(
        &bench,
        &["cases/records/machine.toml", "--data", "cases/records", "--repaired", "repaired.toml"],
    );
    let chart = |settings: Value| {
        let answer = served.post("replay", &json!({ "settings": settings, "record": 2 }));
        answer["charts"][0].clone()
    };
    let as_believed = chart(json!({}));
    let series = as_believed["series"].as_array().unwrap();
    let names: Vec<&str> = series.iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["measured", "the machine as set", "repaired"]);
    let [measured, set, repaired] = [0, 1, 2].map(|i| values(&series[i]));
    let error = |of: &[f64]| {
        let both = measured.iter().zip(of).filter(|(a, b)| a.is_finite() && b.is_finite());
        rms(both.map(|(a, b)| a - b))
    };
    // With 4 N of friction in 10 N of command, the repaired machine predicts all but the noise.
    assert!(error(&repaired) < 0.1 * error(&set), "{} and {}", error(&repaired), error(&set));
    let moved = chart(json!({ "springs.guide.damping": 200.0 }));
    assert_ne!(moved["series"][1], as_believed["series"][1]);
}
