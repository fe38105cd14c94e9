//! `feeler live` and `feeler compare`, without a browser; `.ci/browser` opens their pages.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::bench::{BAD_INPUT, Bench, DONE, PRESS, exists};
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

#[test]
fn truth_what_differs_is_told_and_a_folder_of_a_run_is_its_scenario() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let set = ["--set", "controllers.force.kp=0.3"];
    let ran = bench.feeler(&["run", "press.toml"]);
    assert_eq!(ran.code, DONE);
    assert_eq!(bench.feeler(&[&["run", "press.toml"][..], &set].concat()).code, DONE);
    assert!(
        exists(bench.path("out/press/report.html"))
            && exists(bench.path("out/press,controllers.force.kp=0.3/report.html"))
    );
    let of_runs =
        bench.feeler(&["compare", "out/press", "out/press,controllers.force.kp=0.3", "--out", "runs"]);
    let of_file = bench.feeler(&[&["compare", "press.toml", "--out", "file"][..], &set].concat());
    for said in [&of_runs, &of_file] {
        assert_eq!(said.code, DONE, "{}", said.err);
        assert!(
            said.out.contains("controllers.force.kp") && said.out.contains("phase margin"),
            "{}",
            said.out
        );
    }
    // Each name is above its column.
    let head = of_runs.out.lines().next().unwrap();
    let row = of_runs.out.lines().find(|line| line.starts_with(" controllers.force.kp")).unwrap();
    assert_eq!(head.find("press"), row.find("0.2"), "{}", of_runs.out);
    // The figures are equal, because a run is repeated bit for bit.
    let figures = |text: &str| {
        let from = text.find("peak force").unwrap();
        text[from..text.find("wrote").unwrap()].split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(figures(&of_runs.out), figures(&of_file.out));
    // Settling times are equal, because both commands measure rows at the same instants.
    let settling = |text: &str| {
        let from = text.find("settling time").unwrap();
        text[from..].split_whitespace().skip(2).take(2).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(settling(&of_runs.out), settling(&ran.out));
    let page = bench.read("runs/report.html");
    assert!(page.contains("What differs"));
    let data = data_of(&page);
    let planes = data["planes"].as_array().unwrap();
    assert_eq!(planes.len(), 2, "Nyquist's curves, and root loci");
    for (kind, plane) in ["nyquist", "roots"].iter().zip(planes) {
        assert_eq!(plane["kind"], *kind);
        for (colour, name) in ["press", "press,controllers.force.kp=0.3"].iter().enumerate() {
            let own = |path: &&Value| path["colour"] == colour && path["name"] == format!("{name} sampled");
            let of = |path: &&Value| path["colour"] == colour && path["name"] == *name;
            let paths = plane["paths"].as_array().unwrap();
            let found = paths.iter().find(|path| own(path) || of(path)).unwrap_or_else(|| panic!("{plane}"));
            assert!(found["x"].is_object() && found["y"].is_object(), "a curve of many points: {found}");
        }
    }
    // Long numbers are shortened to as many digits as distinguish them.
    for (mass, told) in [("2.12345678901", "2.123457"), ("2.00000000001", "2.00000000001")] {
        let set = format!("bodies.tip.mass={mass}");
        let said = bench.feeler(&["compare", "press.toml", "--set", &set, "--out", "file"]);
        let row = said.out.lines().find(|line| line.starts_with(" bodies.tip.mass ")).unwrap();
        assert!(row.ends_with(&format!(" {told}")), "{row}");
    }
    assert_eq!(bench.feeler(&["compare", "press.toml"]).code, BAD_INPUT);
    assert_eq!(bench.feeler(&["compare", "press.toml", "out"]).code, BAD_INPUT);
}

/// `sustained` is unstable by linear theory: its response grows beyond all others.
#[test]
fn truth_an_unstable_step_response_hides_no_stable_one() {
    let bench = Bench::new();
    let scenario = |name: &str| format!("{}/../scenarios/chatter/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let (stable, unstable) = (scenario("settles"), scenario("sustained"));
    assert_eq!(bench.feeler(&["compare", &stable, &unstable, "--out", "both"]).code, DONE);
    let data = data_of(&bench.read("both/report.html"));
    let charts = data["charts"].as_array().unwrap();
    let steps = charts.iter().find(|chart| chart["y"]["label"] == "reading over reference").unwrap();
    let largest = |i: usize| {
        let all = values(&steps["series"][i]).into_iter().filter(|value| value.is_finite());
        all.fold(0.0_f64, |most, value| most.max(value.abs()))
    };
    let (shown, cut) = (largest(0), largest(1));
    assert!(shown > 1.0 && cut > shown && cut <= 1.5 * shown, "{shown} {cut}");
}

#[test]
fn truth_a_comparison_for_programs_holds_the_runs_and_the_keys_that_differ() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let set = ["--set", "controllers.force.kp=0.3"];
    let of = |arguments: &[&str]| -> Value {
        let said = bench.feeler(&[arguments, &set, &["--json"]].concat());
        assert_eq!(said.code, DONE, "{}", said.err);
        serde_json::from_str(&said.out).unwrap()
    };
    let (ran, both) = (of(&["run", "press.toml"]), of(&["compare", "press.toml", "--out", "both"]));
    let variant = &both["scenarios"][1];
    assert_eq!(variant["name"], set[1]);
    for key in ["outcome", "peak_force_n", "settling_time_s", "bounces"] {
        assert_eq!(variant["run"][key], ran[key], "{key}");
    }
    assert_eq!(variant["theory"]["gain"], 0.3);
    let limits = [0, 1].map(|i| both["scenarios"][i]["theory"]["largest_stable_gain"].as_f64().unwrap());
    assert!((limits[0] / limits[1] - 1.0).abs() < 1e-9, "the limit does not depend on the gain: {limits:?}");
    assert_eq!(
        both["differing"],
        json!([{"key": "controllers.force.kp", "unit": "", "values": ["0.2", "0.3"]}])
    );
    let written: Value = serde_json::from_str(&bench.read("both/compare.json")).unwrap();
    assert_eq!(written["differing"], both["differing"]);
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

fn rms(values: impl Iterator<Item = f64>) -> f64 {
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

#[test]
fn truth_datasets_are_compared_column_by_column_on_the_terminal_too() {
    let bench = records();
    std::fs::create_dir_all(bench.path("cases/other")).unwrap();
    for name in ["machine.toml", "1.csv", "2.csv"] {
        bench.write(&format!("cases/other/{name}"), &bench.read(&format!("cases/records/{name}")));
    }
    let text = bench.read("cases/records/dataset.toml").replace("\"records\"", "\"other\"");
    bench.write("cases/other/dataset.toml", &text);
    // In one record the encoder reads 10 % more.
    let table = bench.read("cases/records/0.csv");
    let column = table.lines().next().unwrap().split(',').position(|name| name == "encoder.reading").unwrap();
    let mut read = Vec::new();
    let mut scaled = String::new();
    for (i, line) in table.lines().enumerate() {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if i > 0 {
            let value: f64 = cells[column].parse().unwrap();
            read.push(value);
            cells[column] = format!("{:e}", 1.1 * value);
        }
        scaled += &(cells.join(",") + "\n");
    }
    bench.write("cases/other/0.csv", &scaled);
    let said = bench.feeler(&["compare", "cases/records", "cases/other", "--out", "both"]);
    assert_eq!(said.code, DONE, "{}", said.err);
    let row = |record: &str, column: &str| {
        let line = said.out.lines().find(|line| line.contains(record) && line.contains(column));
        line.unwrap_or_else(|| panic!("{record}, {column}: {}", said.out)).to_owned()
    };
    assert!(row("1.csv", "encoder.reading").trim_end().ends_with(" 0.0 %"), "{}", said.out);
    let mean = read.iter().sum::<f64>() / read.len() as f64;
    let share = 10.0 * rms(read.iter().copied()) / rms(read.iter().map(|value| value - mean));
    let found = row("0.csv", "encoder.reading");
    assert!(found.trim_end().ends_with(&format!(" {share:.1} %")), "{share}: {found}");
    assert!(bench.read("both/report.html").contains("1.csv"));
    let numbers: Value = serde_json::from_str(&bench.read("both/compare.json")).unwrap();
    let columns = numbers["columns"].as_array().unwrap();
    let same = |column: &&Value| column["record"] == "0.csv" && column["column"] == "encoder.reading";
    let found = columns.iter().find(same).unwrap();
    let told = 100.0 * found["difference"].as_f64().unwrap() / found["variation"].as_f64().unwrap();
    assert!((told - share).abs() < 1e-6 * share, "{told} beside {share}");
}
