//! A wall that is nearer than believed: the model does not touch it where the machine does, so its errors
//! contain no gradient towards the wall.

use std::f64::consts::TAU;

use feeler_diagnosis::dataset::{Channel, Dataset, Driven, Record};
use feeler_diagnosis::diagnose;
use feeler_diagnosis::predict::Predictor;
use feeler_files::Document;
use feeler_plant::assembly::{Source, assemble};
use feeler_plant::description::{Engagement, Machine};
use feeler_plant::effects::Kind;

const SPACING_S: f64 = 1e-3;
const ROWS: usize = 700;
/// Noise of encoder (m), accelerometers (m/s²) and force sensor (N).
const NOISE: [f64; 3] = [2e-7, 0.03, 0.1];
const OFFSET_M: f64 = -1.6e-3;
/// The gap is believed within 5 % of 2 mm. The records cannot separate the offset from an error of the gap.
const RECOVERY_M: f64 = 1e-4;

const BELIEVED: &str = r#"
name = "bench"
[bodies.tool]
mass = 6.0
[springs.guide]
between = ["ground", "tool"]
damping = 60.0
[contacts.tip]
between = ["tool", "ground"]
law = "kelvin-voigt"
stiffness = 1.2e5
damping = 150.0
gap = "2 mm"
[actuators.drive]
on = "tool"
reacts_on = "ground"
kind = "force"
limit = 400.0
[sensors.encoder]
reads = "tool.position"
noise = 2.0e-7
[sensors.accelerometer]
reads = "tool.acceleration"
noise = 0.03
[sensors.force]
reads = "tip.spring_force"
noise = 0.1
"#;

fn machine(effect: &str) -> Machine {
    Document::parse(&format!("{BELIEVED}\n{effect}"), "bench.toml")
        .expect("the text is a machine")
        .scenario
        .machine
}

/// A mean force plus sines, held over two rows.
fn command(push_n: f64, turn: f64) -> Vec<f64> {
    let at = |k: usize| {
        let t = (k / 2 * 2) as f64 * SPACING_S;
        push_n
            + (1..=8)
                .map(|i| 2.5 * (TAU * 7.3 * f64::from(i) * t + turn * f64::from(i * i)).sin())
                .sum::<f64>()
    };
    (0..ROWS).map(at).collect()
}

#[test]
fn regress_a_wall_nearer_than_believed_is_found() {
    let believed = machine("");
    let real = machine(&format!("[contacts.tip.effects.surface-offset]\noffset = {OFFSET_M:e}\n"));
    let sensors = believed.sensors.keys().zip(NOISE).enumerate();
    let channels = sensors.map(|(i, (name, noise))| Channel {
        column: name.clone(),
        source: Source::Sensor(i),
        noise,
        resolution: 0.0,
    });
    let experiments = [
        (Engagement::Free, 0.0, 0.4, false),
        (Engagement::Free, 0.0, 1.3, true),
        (Engagement::Unilateral, 14.0, 0.9, false),
        (Engagement::Unilateral, 18.0, 2.1, true),
    ];
    let records = experiments.into_iter().enumerate().map(|(i, (engagement, push_n, turn, is_check))| {
        let series = vec![vec![0.0; ROWS]; 3];
        let record = Record::even(format!("{i}.csv"), SPACING_S, vec![command(push_n, turn)], series);
        Record { engagement: Some(engagement), is_check, ..record }
    });
    let (channels, records) = (channels.collect(), records.collect());
    let drives = vec![Driven { drive: 0, column: "command".into(), hold_s: Some(SPACING_S), noise: None }];
    let mut dataset = Dataset::new("bench", believed, drives, channels, records);
    let mut state: u64 = 11;
    for r in 0..dataset.records.len() {
        let assembly = assemble(&real).expect("it assembles");
        let mut seen = Predictor::new(assembly, &dataset, &dataset.records[r])
            .and_then(|mut real| real.free())
            .expect("it moves")
            .series;
        for (series, sigma) in seen.iter_mut().zip(NOISE) {
            for x in series.iter_mut() {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                *x += sigma * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt();
            }
        }
        dataset.records[r].series = seen;
    }
    let answer = diagnose(&dataset, &|_| {}).unwrap();
    let effect = answer.effects.first().expect("an effect is named");
    assert_eq!(effect.kind, Kind::SurfaceOffset, "{:?}", answer.attempts);
    let offset = &effect.parameters["offset"];
    assert!((offset.value - OFFSET_M).abs() < RECOVERY_M, "{offset:?}");
    // The interval includes the uncertainty of the believed gap.
    assert!(offset.ci90[0] < OFFSET_M && OFFSET_M < offset.ci90[1], "{offset:?}");
    assert_eq!(answer.places[0].place, "contact");
}
