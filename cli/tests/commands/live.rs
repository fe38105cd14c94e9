//! `feeler live` and `feeler compare`, without a browser; `.ci/browser` opens their pages.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};

use crate::bench::{BAD_INPUT, Bench, DONE, PRESS, exists};

/// A running server, which ends with its test.
struct Served {
    child: Child,
    host: String,
    secret: String,
}

impl Served {
    fn new(bench: &Bench, file: &str) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_feeler"))
            .args(["live", bench.path(file).to_str().unwrap()])
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
        // A response may come in pieces, each after its length.
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
    let served = Served::new(&bench, "press.toml");
    assert!(served.host.starts_with("127.0.0.1:") && served.secret.len() == 32, "{}", served.host);
    let own = format!("/{}/", served.secret);
    let status = |path: &str, host: &str| served.ask("GET", path, host, "").0;
    assert_eq!(status(&own, &served.host), 200);
    let guess = format!("/{}/", "0".repeat(32));
    let other = format!("{own}../press.toml");
    for path in ["/", "/press.toml", guess.as_str(), other.as_str()] {
        assert_eq!(status(path, &served.host), 404, "{path}");
    }
    // A host name that someone else points at this computer.
    assert_eq!(status(&own, "attacker.example"), 404);
}

#[test]
fn truth_a_number_that_is_moved_moves_what_follows_and_is_written_with_its_comments() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let served = Served::new(&bench, "press.toml");
    let state = |kp: f64| served.post("state", &json!({ "settings": { "controllers.force.kp": kp } }));
    let (calm, wild) = (state(0.05), state(40.0));
    for chart in ["force", "drive", "step", "magnitude", "phase"] {
        assert!(calm["charts"][chart]["series"][0]["values"].is_object(), "{chart}");
    }
    assert!(calm["planes"]["nyquist"].is_object() && calm["planes"]["locus"].is_object());
    assert_ne!(calm["lead"], wild["lead"]);
    assert_eq!(calm["stable"], wild["stable"], "stable gains do not depend on the gain");
    assert!(wild["lead"].as_str().unwrap().contains("unstable"), "{}", wild["lead"]);
    let refused = served.post("state", &json!({ "settings": { "bodies.tip.mass": -1.0 } }));
    assert!(refused["problem"].as_str().unwrap().contains("bodies.tip.mass"), "{refused}");

    let keys = json!({ "x": "controllers.force.kp", "y": "bodies.tip.mass" });
    let map = json!({ "settings": {}, "keys": keys, "points": [[0.05, 2.0], [40.0, 2.0], [0.05, -1.0]] });
    let outcomes = served.post("map", &map)["outcomes"].clone();
    assert_eq!(outcomes[0], calm["outcome"]);
    assert!(outcomes[1] != outcomes[0] && outcomes[2].is_null(), "{outcomes}");

    let written = served.post("write", &json!({ "settings": { "bodies.tip.mass": 2.5 } }));
    assert!(written["problem"].is_null(), "{written}");
    assert_eq!(bench.read("press.toml.bak"), PRESS);
    let now = bench.read("press.toml");
    assert!(now != PRESS && now.lines().count() == PRESS.lines().count(), "{now}");
    let checked = bench.feeler(&["check", "press.toml"]);
    assert_eq!(checked.code, DONE, "{}", checked.err);
}

#[test]
fn truth_what_differs_is_told_and_a_folder_of_a_run_is_its_scenario() {
    let bench = Bench::new();
    bench.write("press.toml", PRESS);
    let set = ["--set", "controllers.force.kp=0.3"];
    assert_eq!(bench.feeler(&["run", "press.toml"]).code, DONE);
    assert_eq!(bench.feeler(&[&["run", "press.toml"][..], &set].concat()).code, DONE);
    assert!(
        exists(bench.path("out/press/report.html")) && exists(bench.path("out/press,kp=0.3/report.html"))
    );
    let of_runs = bench.feeler(&["compare", "out/press", "out/press,kp=0.3", "--out", "runs"]);
    let of_file = bench.feeler(&[&["compare", "press.toml", "--out", "file"][..], &set].concat());
    for said in [&of_runs, &of_file] {
        assert_eq!(said.code, DONE, "{}", said.err);
        assert!(
            said.out.contains("controllers.force.kp") && said.out.contains("phase margin"),
            "{}",
            said.out
        );
    }
    // The same figures: a run is repeated bit for bit.
    let figures = |text: &str| {
        let from = text.find("peak force").unwrap();
        text[from..text.find("wrote").unwrap()].split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(figures(&of_runs.out), figures(&of_file.out));
    assert!(bench.read("runs/report.html").contains("What differs"));
    assert_eq!(bench.feeler(&["compare", "press.toml"]).code, BAD_INPUT);
    assert_eq!(bench.feeler(&["compare", "press.toml", "out"]).code, BAD_INPUT);
}
