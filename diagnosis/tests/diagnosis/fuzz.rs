//! Any records give an answer or an error, never a panic: over sampling rates, channels and rows.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::time::{Duration, Instant};

use feeler_diagnosis::dataset::{Channel, Dataset, Driven, Record};
use feeler_diagnosis::{Budget, diagnose_within};
use feeler_files::Document;
use feeler_plant::assembly::Source;
use feeler_problem::Remedy;

/// Readings of the sensors, in turn.
const READS: [&str; 4] = ["carriage.position", "carriage.velocity", "carriage.acceleration", "tool.force"];
const RATES_HZ: [f64; 9] = [20.0, 50.0, 100.0, 200.0, 200.0, 500.0, 1000.0, 4000.0, 10_000.0];
/// Relative deviation of a record's rate from the nominal one, as clocks have it.
const CLOCK: f64 = 1e-9;

/// Amplitudes of the sensors, in turn, SI.
const SIZES: [f64; 4] = [0.01, 0.1, 1.0, 10.0];

/// Random numbers from 0 to 1, equal in every run.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }
}

/// A carriage that may touch a wall, with this many sensors.
fn machine_text(sensors: usize) -> String {
    let mut text = String::from(
        r#"
name = "fuzzed"
[bodies.carriage]
mass = 2.0
[springs.guide]
between = ["ground", "carriage"]
damping = 5.0
[contacts.tool]
between = ["carriage", "ground"]
law = "kelvin-voigt"
stiffness = 2.0e4
damping = 20.0
gap = 0.01
[actuators.drive]
on = "carriage"
reacts_on = "ground"
kind = "force"
"#,
    );
    for i in 0..sensors {
        let reads = READS[i % READS.len()];
        let _ = writeln!(text, "[sensors.s{i}]\nreads = \"{reads}\"\nnoise = 1.0e-5");
    }
    text
}

/// Records that no machine has made: sines, steps, noise and standstill.
fn dataset(draw: &mut Draw, rows: usize, sensors: usize, rate_hz: f64) -> Dataset {
    let text = machine_text(sensors);
    let machine = Document::parse(&text, "fuzzed.toml").expect("the text is a machine").scenario.machine;
    let channels: Vec<Channel> = (0..sensors)
        .map(|i| Channel { column: format!("s{i}"), source: Source::Sensor(i), noise: 1e-5, resolution: 0.0 })
        .collect();
    let experiments = 2 + draw.below(3);
    let records = (0..experiments)
        .map(|i| {
            let spacing_s = (1.0 + CLOCK * (draw.next() - 0.5)) / rate_hz;
            let hz = 10.0_f64.powf(2.0 * draw.next() - 1.0);
            let shape = draw.below(4);
            let of = |k: usize, size: f64, noise: f64| {
                let t = k as f64 * spacing_s;
                size * match shape {
                    0 => (TAU * hz * t).sin(),
                    1 => f64::from(u8::from((hz * t).fract() > 0.5)),
                    2 => 0.0,
                    _ => (TAU * hz * t * t).sin() * t,
                } + noise
            };
            let commands = vec![(0..rows).map(|k| of(k, 20.0, draw.next())).collect()];
            let series = (0..sensors)
                .map(|c| (0..rows).map(|k| of(k, SIZES[c % SIZES.len()], 1e-4 * draw.next())).collect())
                .collect();
            let repeat = (draw.next() < 0.3).then(|| "again".to_owned());
            Record {
                is_check: i == 0,
                repeat,
                silent: (0..sensors).map(|_| draw.next() < 0.05).collect(),
                ..Record::even(format!("record-{i}.csv"), spacing_s, commands, series)
            }
        })
        .collect();
    let drives = vec![Driven { drive: 0, column: "command".into(), hold_s: None, noise: None }];
    Dataset::new("fuzzed", machine, drives, channels, records)
}

/// Asserts that an answer is finite; `false` without one.
fn holds(dataset: &Dataset, budget: Budget) -> bool {
    let Ok(answer) = diagnose_within(dataset, budget, &|_| {}) else { return false };
    assert!(answer.gap.refit.is_finite() && answer.gap.before.is_finite(), "{:?}", answer.gap);
    assert!(answer.cells.iter().all(|cell| cell.seconds > 0.0));
    true
}

#[test]
fn prop_short_records_of_any_rate_and_any_channels_get_an_answer_or_a_reason() {
    let mut draw = Draw(3);
    let mut answered = 0;
    for (i, rate_hz) in RATES_HZ.into_iter().enumerate() {
        let rows = [10, 11, 16, 33, 60, 120][draw.below(6)];
        let sensors = [1, 2, 4, 7, 20][i % 5];
        answered += usize::from(holds(&dataset(&mut draw, rows, sensors, rate_hz), Budget::unlimited()));
    }
    // The reason why there is no answer may be the exception.
    assert!(2 * answered > RATES_HZ.len(), "{answered} of {}", RATES_HZ.len());
}

#[test]
fn prop_records_of_some_seconds_get_an_answer_or_a_reason() {
    let mut draw = Draw(4);
    let sizes = [(400, 2, 20.0), (2500, 3, 500.0), (4000, 1, 10_000.0)];
    let answered = sizes.map(|(rows, sensors, rate_hz)| {
        holds(&dataset(&mut draw, rows, sensors, rate_hz), Budget::of(Duration::from_secs(10)))
    });
    assert!(answered.contains(&true));
}

/// Records of many rows end soon after their budget, in an unoptimised build too: a step of a fit that began
/// in time is finished. The margin is that of a busy machine.
#[test]
fn prop_records_of_many_rows_end_soon_after_their_budget() {
    let mut draw = Draw(6);
    let (budget_s, margin_s) = (5, 60);
    for (rows, sensors, rate_hz) in [(200_000, 1, 1000.0), (100_000, 2, 10_000.0)] {
        let records = dataset(&mut draw, rows, sensors, rate_hz);
        let begun = Instant::now();
        holds(&records, Budget::of(Duration::from_secs(budget_s)));
        let took_s = begun.elapsed().as_secs();
        assert!(took_s < budget_s + margin_s, "{rows} rows took {took_s} s");
    }
}

/// Long version: `cargo test --release -p feeler-diagnosis --test diagnosis -- --ignored fuzz`.
#[test]
#[ignore = "takes an hour"]
fn prop_long_records_of_any_rate_and_any_channels_get_an_answer_or_a_reason() {
    let mut draw = Draw(5);
    for _ in 0..200 {
        // Rows of each of up to four experiments: up to a million in all.
        let rows = (10.0 * 10.0_f64.powf(4.4 * draw.next())) as usize;
        let sensors = 1 + draw.below(20);
        let rate_hz = RATES_HZ[draw.below(RATES_HZ.len())];
        holds(&dataset(&mut draw, rows, sensors, rate_hz), Budget::of(Duration::from_secs(60)));
    }
}

/// Replacements for a number of a mutated file.
const NUMBERS: [&str; 12] =
    ["0", "-1", "1e-300", "1e300", "1e9", "1e-9", "inf", "nan", "true", "\"x\"", "\"1e9 Hz\"", ""];

/// A text with one line removed, repeated or cut, or with one of its numbers replaced.
fn mutated(text: &str, draw: &mut Draw) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let at = draw.below(lines.len());
    let is_number = |c: char| c.is_ascii_digit() || ".-+e".contains(c);
    let starts: Vec<usize> =
        lines[at].char_indices().filter(|(_, c)| c.is_ascii_digit()).map(|(i, _)| i).collect();
    match draw.below(8) {
        0 => drop(lines.remove(at)),
        1 => lines.insert(at, lines[at].clone()),
        2 => {
            let end = draw.below(lines[at].len() + 1);
            lines[at].truncate(end);
        }
        _ if starts.is_empty() => lines.truncate(at),
        _ => {
            let start = starts[draw.below(starts.len())];
            let length = lines[at][start..].find(|c| !is_number(c)).unwrap_or(lines[at].len() - start);
            lines[at].replace_range(start..start + length, NUMBERS[draw.below(NUMBERS.len())]);
        }
    }
    lines.join("\n") + "\n"
}

/// Datasets with up to three mistakes in machine, dataset or record are read, or refused with a remedy.
fn datasets_with_slips(cases: usize) {
    let record: String = (0..60).fold("t_s,force_n,x_m\n".to_owned(), |mut text, k| {
        let t = 0.01 * f64::from(k);
        let _ = writeln!(text, "{t:.2},{:.4},{:.6}", (7.0 * t).sin(), 0.01 * (7.0 * t).cos());
        text
    });
    let dataset = "machine = \"machine.toml\"\n[columns.force_n]\nsignal = \"drive.command\"\n\
                   [columns.x_m]\nsignal = \"s0.reading\"\n[[experiments]]\nfile = \"record.csv\"\n";
    let whole =
        [("machine.toml", machine_text(1)), ("dataset.toml", dataset.to_owned()), ("record.csv", record)];
    let folder = tempfile::tempdir().expect("a folder");
    let (mut draw, mut read) = (Draw(11), 0);
    for case in 0..cases {
        let mut texts = whole.clone();
        for _ in 0..=draw.below(3) {
            let text = &mut texts[draw.below(3)].1;
            *text = mutated(text, &mut draw);
        }
        for (name, text) in &texts {
            std::fs::write(folder.path().join(name), text).expect("it is written");
        }
        match Dataset::load(folder.path()) {
            Ok(found) => {
                read += 1;
                let numbers = found.records.iter().flat_map(|record| record.series.iter().flatten());
                assert!(numbers.into_iter().all(|x| x.is_finite()), "{case}");
            }
            Err(error) => assert!(!error.remedy().is_empty(), "{case}: {error}"),
        }
    }
    assert!((cases / 20..cases).contains(&read), "{read} of {cases} are read");
}

#[test]
fn prop_datasets_with_slips_are_read_or_refused() {
    datasets_with_slips(500);
}

/// Long version: `cargo test --release -p feeler-diagnosis --test diagnosis -- --ignored slips`.
#[test]
#[ignore = "takes minutes"]
fn prop_twenty_thousand_datasets_with_slips_are_read_or_refused() {
    datasets_with_slips(20_000);
}
