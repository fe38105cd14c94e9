//! Friction that bends before it slides is named where records resolve the bending, and only there.

use std::f64::consts::TAU;

use feeler_diagnosis::dataset::{Channel, Dataset, Driven, Record};
use feeler_diagnosis::diagnose;
use feeler_diagnosis::predict::Predictor;
use feeler_files::Document;
use feeler_plant::assembly::{Source, assemble};
use feeler_plant::effects::Kind;

use crate::Noise;

const SPACING_S: f64 = 1e-3;
const ROWS: usize = 2000;
/// Bristles of the machine below bend by 14 um.
const NOISE_M: f64 = 1e-8;

const BELIEVED: &str = r#"
name = "axis"
[bodies.carriage]
mass = 10.0
[springs.guide]
between = ["ground", "carriage"]
damping = 20.0
[actuators.drive]
on = "carriage"
reacts_on = "ground"
kind = "force"
[sensors.encoder]
reads = "carriage.position"
"#;

/// A force whose frequency rises evenly.
fn chirp(peak_n: f64, [from_hz, to_hz]: [f64; 2]) -> Vec<f64> {
    let lasts_s = ROWS as f64 * SPACING_S;
    let at = |t: f64| peak_n * (TAU * (from_hz * t + 0.5 * (to_hz - from_hz) / lasts_s * t * t)).sin();
    (0..ROWS).map(|k| at(k as f64 * SPACING_S)).collect()
}

/// Records of the axis with an effect at its guide: five below the friction of 7 N, two far above.
fn records_of(effect: &str) -> Dataset {
    let machine = |text: &str| Document::parse(text, "axis.toml").expect("a machine").scenario.machine;
    let commands = [
        (chirp(3.0, [0.5, 5.0]), false),
        (chirp(12.0, [1.0, 3.0]), false),
        (chirp(2.5, [2.0, 10.0]), false),
        (chirp(3.4, [0.5, 3.0]), false),
        (chirp(3.6, [1.0, 8.0]), true),
        (chirp(3.2, [0.5, 6.0]), true),
        (chirp(20.0, [2.0, 4.0]), true),
    ];
    let record = |(i, (command, is_check)): (usize, (Vec<f64>, bool))| {
        let even = Record::even(format!("{i}.csv"), SPACING_S, vec![command], vec![vec![0.0; ROWS]]);
        Record { is_check, ..even }
    };
    let records = commands.into_iter().enumerate().map(record).collect();
    let channel =
        Channel { column: "encoder".into(), source: Source::Sensor(0), noise: NOISE_M, resolution: 0.0 };
    let drives = vec![Driven { drive: 0, column: "command".into(), hold_s: Some(SPACING_S) }];
    let mut dataset = Dataset::new("axis", machine(BELIEVED), drives, vec![channel], records);
    let real = assemble(&machine(&format!("{BELIEVED}{effect}"))).expect("it assembles");
    let mut noise = Noise(11);
    for r in 0..dataset.records.len() {
        let free = Predictor::new(real.clone(), &dataset, &dataset.records[r]).and_then(|mut run| run.free());
        let mut series = free.expect("it moves").series;
        series[0].iter_mut().for_each(|x| *x += NOISE_M * noise.draw());
        dataset.records[r].series = series;
    }
    dataset
}

#[test]
fn truth_bristles_are_named_where_records_resolve_them_and_dry_friction_is_not_called_bristles() {
    let bristles = r"
        [springs.guide.effects.lugre-friction]
        stiffness = 5.0e5
        damping = 3000.0
        coulomb = 4.0
        static = 7.0
        velocity = 5.0e-3
    ";
    let answer = diagnose(&records_of(bristles), &|_| {}).unwrap();
    let found = answer.effects.iter().find(|effect| effect.accepted).expect("an effect is named");
    assert_eq!(found.kind, Kind::LugreFriction);
    // Widths of the intervals for friction, which no law describes exactly.
    for (name, value) in [("stiffness", 5.0e5), ("damping", 3000.0), ("coulomb", 4.0), ("static", 7.0)] {
        let [low, high] = found.parameters[name].ci90;
        assert!(low < value && value < high, "{name}: {low} to {high}");
    }
    let stiff = "[springs.guide.effects.coulomb-friction]\nlevel = 4.0\n";
    let answer = diagnose(&records_of(stiff), &|_| {}).unwrap();
    let found: Vec<Kind> = answer.effects.iter().filter(|effect| effect.accepted).map(|e| e.kind).collect();
    assert_eq!(found, [Kind::CoulombFriction]);
}
