//! Position against acceleration of bodies that move as one: they tell of a clock that runs behind, and of units.

use feeler_plant::assembly::{Assembly, GROUND_NODE, Source, assemble};
use feeler_plant::description::{Machine, Quantity};

use super::{Channel, Dataset, Fault, FaultKind, Record};

/// Span of the second difference, s: long enough for an encoder's noise, short enough to follow the motion.
const SPAN_S: f64 = 4e-3;
/// Largest shift that is looked for, s.
const MOST_SHIFT_S: f64 = 0.05;
/// Correlation from which on two series are the same motion.
const SAME_MOTION: f64 = 0.85;
/// Shift in rows from which on it is stated.
const STATED_ROWS: f64 = 1.0;
/// Factors between units that are mixed up: millimetres, micrometres, degrees, g.
const FACTORS: [(f64, &str); 5] = [
    (1e3, "a thousand (mm for m?)"),
    (1e6, "a million (µm for m?)"),
    (57.295_779_5, "57.3 (degrees for radians?)"),
    (9.806_65, "9.81 (g for m/s²?)"),
    (1e2, "a hundred (cm for m?)"),
];
/// How near the factor must be, as a fraction.
const NEAR: f64 = 0.1;

/// States a shift or a factor between a position and an acceleration of the same motion, in the first record that shows it.
pub(super) fn check(dataset: &Dataset) -> Vec<Fault> {
    let Ok(assembly) = assemble(&dataset.machine) else { return Vec::new() };
    let node = |channel: &Channel| node_of(&dataset.machine, &assembly, channel);
    let mut faults = Vec::new();
    for (p, position) in dataset.channels.iter().enumerate() {
        let Some(x) = node(position).filter(|_| position.quantity(&dataset.machine) == Quantity::Position) else { continue };
        for (a, acceleration) in dataset.channels.iter().enumerate() {
            let Some(y) = node(acceleration).filter(|_| acceleration.quantity(&dataset.machine) == Quantity::Acceleration) else {
                continue;
            };
            if x != y {
                continue;
            }
            let found = dataset.records.iter().find_map(|record| Some((record, compare(record, p, a)?)));
            let Some((record, comparison)) = found else { continue };
            let mut note = |kind| {
                faults.push(Fault { file: record.name.clone(), column: Some(acceleration.column.clone()), row: None, kind });
            };
            if comparison.late_s.abs() > STATED_ROWS * record.spacing_s {
                note(FaultKind::ClockOffset { other: position.column.clone(), late_s: comparison.late_s });
            }
            if let Some(what) = mixed_up(comparison.factor) {
                note(FaultKind::Units { other: position.column.clone(), factor: comparison.factor, what });
            }
        }
    }
    faults
}

/// The body that a channel reads.
fn node_of(machine: &Machine, assembly: &Assembly, channel: &Channel) -> Option<usize> {
    let source = match channel.source {
        Source::Sensor(i) => assembly.sensors.get(i)?.source,
        source => source,
    };
    match source {
        // Bodies that are believed rigid are compared as well only where they are the same one: a joint may give way.
        Source::Node(node, _) if node != GROUND_NODE && node <= machine.bodies.len() => Some(node),
        _ => None,
    }
}

fn mixed_up(factor: f64) -> Option<&'static str> {
    let near = |wanted: f64| (factor / wanted - 1.0).abs() < NEAR || (factor * wanted - 1.0).abs() < NEAR;
    FACTORS.iter().find(|(wanted, _)| near(*wanted)).map(|(_, what)| *what)
}

struct Comparison {
    /// By how much the acceleration is behind the position.
    late_s: f64,
    /// Acceleration read over that of the position.
    factor: f64,
}

/// Compares where both show the same motion.
fn compare(record: &Record, position: usize, acceleration: usize) -> Option<Comparison> {
    let m = ((SPAN_S / record.spacing_s).round() as usize).max(1);
    let most = (MOST_SHIFT_S / record.spacing_s) as usize;
    let (x, y) = (&record.series[position], &record.series[acceleration]);
    let rows = x.len();
    if rows < 4 * (m + most) {
        return None;
    }
    // A second difference over a span is the acceleration under a triangle of that span; the accelerometer goes under the same triangle.
    let scale = (m as f64 * record.spacing_s).powi(2);
    let moved: Vec<f64> = (m..rows - m).map(|k| (x[k + m] - 2.0 * x[k] + x[k - m]) / scale).collect();
    let weight = |j: usize| 1.0 - (j as f64 - m as f64).abs() / m as f64;
    let read: Vec<f64> = (m..rows - m).map(|k| (0..=2 * m).map(|j| weight(j) * y[k + j - m]).sum::<f64>() / m as f64).collect();
    let inner = most..moved.len() - most;
    let correlation = |shift: isize| {
        let (mut xy, mut xx, mut yy) = (0.0, 0.0, 0.0);
        for k in inner.clone() {
            let (a, b) = (moved[k], read[k.checked_add_signed(shift).unwrap_or(0)]);
            xy += a * b;
            xx += a * a;
            yy += b * b;
        }
        (xy / (xx * yy).sqrt().max(f64::MIN_POSITIVE), xy / xx.max(f64::MIN_POSITIVE))
    };
    let reach = most.cast_signed();
    let best = (-reach..=reach).max_by(|&i, &j| correlation(i).0.total_cmp(&correlation(j).0))?;
    let (height, factor) = correlation(best);
    if height < SAME_MOTION {
        return None;
    }
    // The top of a parabola through the best shift and its neighbours.
    let part = if best.abs() < reach {
        let (before, after) = (correlation(best - 1).0, correlation(best + 1).0);
        0.5 * (before - after) / (before - 2.0 * height + after)
    } else {
        0.0
    };
    Some(Comparison { late_s: (best as f64 + part) * record.spacing_s, factor })
}
