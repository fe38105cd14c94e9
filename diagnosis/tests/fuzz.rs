//! Any records get an answer or a reason, never a panic: over sampling rates, channels and rows.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use feeler_diagnosis::dataset::{Channel, Dataset, Record};
use feeler_diagnosis::diagnose;
use feeler_files::Document;
use feeler_plant::assembly::Source;

/// Kinds of reading that sensors cycle through.
const READS: [&str; 4] = ["carriage.position", "carriage.velocity", "carriage.acceleration", "tool.force"];
const RATES_HZ: [f64; 9] = [20.0, 50.0, 100.0, 200.0, 200.0, 500.0, 1000.0, 4000.0, 10_000.0];
/// Relative departure of a record's rate from its nominal one, as clocks have it.
const CLOCK: f64 = 1e-9;

/// Amplitudes that sensors cycle through, SI.
const SIZES: [f64; 4] = [0.01, 0.1, 1.0, 10.0];

/// Numbers from 0 to 1, the same on every run.
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

/// A carriage that may touch a wall, read by this many sensors.
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

/// Records that no machine made: sines, steps, noise and standstill.
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
            Record {
                name: format!("record-{i}.csv"),
                engagement: None,
                is_check: i == 0,
                repeat: (draw.next() < 0.3).then(|| "again".to_owned()),
                start_s: 0.0,
                times_s: (0..rows).map(|k| k as f64 * spacing_s).collect(),
                spacing_s,
                commands,
                series,
                silent: (0..sensors).map(|_| draw.next() < 0.05).collect(),
                bridged: Vec::new(),
            }
        })
        .collect();
    Dataset {
        name: "fuzzed".into(),
        machine,
        tolerance: indexmap::IndexMap::default(),
        drives: vec![(0, "command".into())],
        holds_s: vec![None],
        loops: Vec::new(),
        channels,
        records,
        warnings: Vec::new(),
    }
}

/// Answers are finite where there are any.
fn holds(dataset: &Dataset) {
    if let Ok(answer) = diagnose(dataset, &|_| {}) {
        assert!(answer.gap.refit.is_finite() && answer.gap.before.is_finite(), "{:?}", answer.gap);
        assert!(answer.cells.iter().all(|cell| cell.seconds > 0.0));
    }
}

#[test]
fn prop_short_records_of_any_rate_and_any_channels_get_an_answer_or_a_reason() {
    let mut draw = Draw(3);
    for (i, rate_hz) in RATES_HZ.into_iter().enumerate() {
        let rows = [10, 11, 16, 33, 60, 120][draw.below(6)];
        let sensors = [1, 2, 4, 7, 20][i % 5];
        holds(&dataset(&mut draw, rows, sensors, rate_hz));
    }
}

/// The long form: `cargo test --release -p feeler-diagnosis --test fuzz -- --ignored`.
#[test]
#[ignore = "takes an hour"]
fn prop_long_records_of_any_rate_and_any_channels_get_an_answer_or_a_reason() {
    let mut draw = Draw(5);
    for _ in 0..200 {
        let rows = (10.0 * 10.0_f64.powf(4.0 * draw.next())) as usize;
        let sensors = 1 + draw.below(20);
        let rate_hz = RATES_HZ[draw.below(RATES_HZ.len())];
        holds(&dataset(&mut draw, rows, sensors, rate_hz));
    }
}
