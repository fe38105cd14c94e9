//! `feeler compare`, without a browser; `.ci/browser` opens its page.

use serde_json::{Value, json};

use crate::bench::{BAD_INPUT, Bench, DONE, PRESS, exists};
use crate::diagnose::records;
use crate::live::{data_of, rms, values};

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
