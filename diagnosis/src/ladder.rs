//! The disturbance ladder: an unknown force (or an unknown error of a reading) allowed at one place after the other, what it would explain, and
//! what it goes with. Its shape against position, speed, drive force and time is the portrait of what the machine lacks.

use feeler_plant::description::Quantity;
use feeler_plant::effects::Place;

use crate::fit::Task;
use crate::odds::looks;
use crate::predict::Prediction;
use crate::report::{PortraitPoint, Rung};
use crate::search::{Scored, missing_acceleration, moving_mass};
use crate::starts::ripples;
use crate::unknown::{explained, portrait};

/// Rows averaged into one point.
const AVERAGE: usize = 8;
/// Points handed on for drawing.
const POINTS: usize = 800;
/// Share of the missing force's variance from which a wave over position is named.
const LEAST_WAVE: f64 = 0.01;
/// Mean square residuals below this are noise.
const QUIET: f64 = 1.0;

/// The rungs for a fitted model, the one that explains most first.
pub(crate) fn ladder(task: &Task<'_>, scored: &Scored) -> Vec<Rung> {
    let dataset = task.dataset;
    let mass = moving_mass(dataset, scored);
    let of_kind = |wanted: &[Quantity]| -> Vec<usize> {
        (0..dataset.channels.len()).filter(|&c| wanted.contains(&dataset.channels[c].quantity(&dataset.machine))).collect()
    };
    let accelerations = of_kind(&[Quantity::Acceleration]);
    let positions = of_kind(&[Quantity::Position]);
    let forces = of_kind(&[Quantity::Force, Quantity::SpringForce]);
    let records = &dataset.records;
    let residual = |r: usize, prediction: &Prediction, c: usize| -> Vec<f64> {
        records[r].series[c].iter().zip(&prediction.series[c]).map(|(m, p)| m - p).collect()
    };
    let mut rungs = Vec::new();
    let mut add = |place: Place, only: Option<bool>, channels: &[usize], freed: &dyn Fn(usize, &Prediction) -> Vec<f64>| {
        if !channels.is_empty() {
            rungs.push(rung(task, scored, place, only, channels, freed));
        }
    };
    let common = |r: usize, p: &Prediction| missing_acceleration(dataset, r, p).iter().map(|a| mass * a).collect();
    let carriers = if accelerations.is_empty() { &positions } else { &accelerations };
    add(Place::Guide, Some(false), carriers, &common);
    add(Place::Contact, Some(true), carriers, &common);
    if let [first, .., last] = accelerations[..] {
        add(Place::Transmission, None, &[first, last], &|r, p| {
            residual(r, p, last).iter().zip(residual(r, p, first)).map(|(a, b)| 0.25 * mass * (a - b)).collect()
        });
    }
    if !accelerations.is_empty() {
        add(Place::Base, None, &positions, &|r, p| residual(r, p, positions[0]).iter().map(|x| mass * p.omega.powi(2) * x).collect());
    }
    add(Place::ForceSensor, None, &forces, &|r, p| residual(r, p, forces[0]));
    rungs.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    rungs
}

fn rung(
    task: &Task<'_>,
    scored: &Scored,
    place: Place,
    only: Option<bool>,
    channels: &[usize],
    freed: &dyn Fn(usize, &Prediction) -> Vec<f64>,
) -> Rung {
    let mut points: Vec<PortraitPoint> = Vec::new();
    let mut evidence = 0.0;
    for (r, record) in task.dataset.records.iter().enumerate() {
        let Some(prediction) = task.predict(&scored.fitted.model, &scored.fitted.theta, r) else { continue };
        let chosen = |k: usize| only.is_none_or(|wanted| prediction.touching[k] == wanted);
        let share = (0..record.len()).filter(|&k| chosen(k)).count() as f64 / record.len() as f64;
        for &c in channels {
            evidence += 0.5 * share * looks(record) * ((scored.misfits[r][c] + QUIET) / (2.0 * QUIET)).ln();
        }
        if record.is_check {
            continue;
        }
        for (block, force) in freed(r, &prediction).chunks(AVERAGE).enumerate() {
            let k = block * AVERAGE + force.len() / 2;
            if chosen(k) {
                let [position_m, velocity_m_per_s, drive_n] = prediction.stroke[k];
                let missing_n = force.iter().sum::<f64>() / force.len() as f64;
                let time_s = record.start_s + k as f64 * record.spacing_s;
                points.push(PortraitPoint { position_m, velocity_m_per_s, drive_n, time_s, missing_n });
            }
        }
    }
    let rms_n = (points.iter().map(|p| p.missing_n.powi(2)).sum::<f64>() / points.len().max(1) as f64).sqrt();
    let goes_with = shares(&points);
    let thin = points.len().div_ceil(POINTS).max(1);
    Rung { place: place.name(), evidence, rms_n, goes_with, portrait: points.into_iter().step_by(thin).collect() }
}

/// Root mean square of the missing force of a fitted model over some records, N.
pub(crate) fn missing_force(task: &Task<'_>, scored: &Scored, records: &[usize]) -> f64 {
    let mass = moving_mass(task.dataset, scored);
    let (mut sum, mut rows) = (0.0, 0.0);
    for &r in records {
        let Some(prediction) = task.predict(&scored.fitted.model, &scored.fitted.theta, r) else { continue };
        let missing = missing_acceleration(task.dataset, r, &prediction);
        sum += missing.iter().map(|a| (mass * a).powi(2)).sum::<f64>();
        rows += missing.len() as f64;
    }
    if rows > 0.0 { (sum / rows).sqrt() } else { 0.0 }
}

/// Shapes in the force that is missing even with the accepted effects, said in words.
pub(crate) fn what_is_left(task: &Task<'_>, scored: &Scored) -> Vec<String> {
    let points: Vec<[f64; 2]> = portrait(task, scored, 2, Some(false)).iter().map(|p| [p[0], p[3]]).collect();
    let mean = points.iter().map(|p| p[1]).sum::<f64>() / points.len().max(1) as f64;
    let variance = points.iter().map(|p| (p[1] - mean).powi(2)).sum::<f64>() / points.len().max(1) as f64;
    let series: Vec<(f64, f64)> = points.iter().map(|p| (p[0], p[1])).collect();
    let waves = ripples(&series).into_iter().filter(|wave| 0.5 * wave[0].powi(2) > LEAST_WAVE * variance);
    waves
        .map(|wave| {
            let share = 50.0 * wave[0].powi(2) / variance;
            format!("a force of {:.2} N periodic in position, pitch {:.3e} m, is left ({share:.0} % of what is missing)", wave[0], wave[1])
        })
        .collect()
}

/// Share of the missing force's variance that goes with position, velocity, drive force and time.
fn shares(points: &[PortraitPoint]) -> [(&'static str, f64); 4] {
    let column = |f: &dyn Fn(&PortraitPoint) -> f64| points.iter().map(f).collect::<Vec<f64>>();
    let largest = |f: &dyn Fn(&PortraitPoint) -> f64| points.iter().map(|p| f(p).abs()).fold(1e-12, f64::max);
    let missing = column(&|p| p.missing_n);
    if missing.len() < 20 {
        return [("position", 0.0), ("velocity", 0.0), ("drive force", 0.0), ("time", 0.0)];
    }
    let (span, fast, push, end) =
        (largest(&|p| p.position_m), largest(&|p| p.velocity_m_per_s), largest(&|p| p.drive_n), largest(&|p| p.time_s));
    let powers = |f: &dyn Fn(&PortraitPoint) -> f64| (1..=4).map(|n| column(&|p| f(p).powi(n))).collect::<Vec<_>>();
    let bends = |f: &dyn Fn(&PortraitPoint) -> f64| {
        vec![column(f), column(&|p| f(p).signum()), column(&|p| f(p) * f(p).abs()), column(&|p| (f(p) / 0.05).tanh())]
    };
    [
        ("position", explained(&powers(&|p| p.position_m / span), &missing)),
        ("velocity", explained(&bends(&|p| p.velocity_m_per_s / fast), &missing)),
        ("drive force", explained(&bends(&|p| p.drive_n / push), &missing)),
        ("time", explained(&powers(&|p| p.time_s / end), &missing)),
    ]
}
