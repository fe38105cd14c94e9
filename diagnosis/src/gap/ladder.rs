//! The disturbance ladder: an unknown force (or an unknown error of a reading) is allowed at one place after
//! another. The ladder gives the improvement at each place, and the variables on which the force depends. The
//! graph of the force over position, speed, drive force and time is the portrait of the missing effect.

use std::f64::consts::TAU;

use feeler_plant::description::{Axis, Quantity};
use feeler_plant::effects::{ForceRipple, Place};
use feeler_plant::units::Dimension;

use crate::fit::least_squares::Task;
use crate::fit::missing::{missing_acceleration, moving_mass, noise_acceleration};
use crate::fit::scored::Scored;
use crate::gap::unknown::{explained, portrait};
use crate::kinds::ripples;
use crate::predict::Prediction;
use crate::report::{PortraitPoint, Rung};

/// Rows averaged into one point.
const AVERAGE: usize = 8;
/// Number of points that are kept for drawing.
const POINTS: usize = 800;
/// Smallest share of the missing force's variance that a reported wave over position explains, on fitted and
/// on check experiments alike.
const LEAST_WAVE: f64 = 0.02;
/// Smallest number of periods of a wave within the stroke.
const LEAST_PERIODS: f64 = 2.0;
/// Mean square residuals below this are noise.
const QUIET: f64 = 1.0;

/// The rungs for a fitted model, the one with the largest improvement first.
pub(crate) fn ladder(task: &Task<'_>, scored: &Scored) -> Vec<Rung> {
    let dataset = task.dataset;
    let mass = moving_mass(dataset, scored);
    let of_kind = |wanted: &[Quantity]| -> Vec<usize> {
        (0..dataset.channels.len())
            .filter(|&c| wanted.contains(&dataset.channels[c].quantity(&dataset.machine)))
            .collect()
    };
    let accelerations = of_kind(&[Quantity::Acceleration]);
    // A common force on all bodies does not appear in the difference of a joint's two ends.
    let mut positions = of_kind(&[Quantity::Position]);
    positions.retain(|&c| !task.weights.is_elongation(c));
    let forces = of_kind(&[Quantity::Force, Quantity::SpringForce]);
    let records = &dataset.records;
    let residual = |r: usize, prediction: &Prediction, c: usize| -> Vec<f64> {
        records[r].residual(c, &prediction.series[c])
    };
    let mut rungs = Vec::new();
    let mut add =
        |place: Place, only: Option<bool>, channels: &[usize], freed: &Freed<'_>, left: &Left<'_>| {
            if !channels.is_empty() {
                rungs.push(rung(task, scored, place, only, channels, freed, left));
            }
        };
    let common =
        |r: usize, p: &Prediction| missing_acceleration(dataset, r, p).iter().map(|a| mass * a).collect();
    let nothing = |r: usize, _: &Prediction, _: usize| vec![0.0; records[r].len()];
    // A common force on all moving bodies removes the mean residual of the accelerometers. A force between
    // them removes the difference.
    let apart = |r: usize, p: &Prediction, c: usize| -> Vec<f64> {
        residual(r, p, c)
            .iter()
            .zip(missing_acceleration(dataset, r, p))
            .map(|(own, common)| own - common)
            .collect()
    };
    let together = |r: usize, p: &Prediction, _: usize| missing_acceleration(dataset, r, p);
    let carriers = if accelerations.is_empty() { &positions } else { &accelerations };
    let of_carriers: &Left<'_> = if accelerations.is_empty() { &nothing } else { &apart };
    add(Place::Guide, Some(false), carriers, &common, of_carriers);
    add(Place::Contact, Some(true), carriers, &common, of_carriers);
    if let [first, .., last] = accelerations[..] {
        let between = |r: usize, p: &Prediction| {
            residual(r, p, last)
                .iter()
                .zip(residual(r, p, first))
                .map(|(a, b)| 0.25 * mass * (a - b))
                .collect()
        };
        add(Place::Transmission, None, &[first, last], &between, &together);
    }
    if !accelerations.is_empty() {
        let under = |r: usize, p: &Prediction| {
            residual(r, p, positions[0]).iter().map(|x| mass * p.omega.powi(2) * x).collect()
        };
        add(Place::Base, None, &positions, &under, &nothing);
    }
    add(Place::ForceSensor, None, &forces, &|r, p| residual(r, p, forces[0]), &nothing);
    // A place without data in the records has no rung.
    rungs.retain(|rung| !rung.portrait.is_empty());
    rungs.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    rungs
}

/// The allowed force, or reading error, along a record.
type Freed<'a> = dyn Fn(usize, &Prediction) -> Vec<f64> + 'a;
/// The remaining residual of a channel.
type Left<'a> = dyn Fn(usize, &Prediction, usize) -> Vec<f64> + 'a;

fn rung(
    task: &Task<'_>,
    scored: &Scored,
    place: Place,
    only: Option<bool>,
    channels: &[usize],
    freed: &Freed<'_>,
    left: &Left<'_>,
) -> Rung {
    let mut points: Vec<PortraitPoint> = Vec::new();
    let mut evidence = 0.0;
    for (r, record) in task.dataset.records.iter().enumerate() {
        let Some(prediction) = task.predict(&scored.fitted.model, &scored.fitted.theta, r) else { continue };
        let chosen = |k: usize| only.is_none_or(|wanted| prediction.touching[k] == wanted);
        let share = (0..record.len()).filter(|&k| chosen(k)).count() as f64 / record.len() as f64;
        for &c in channels {
            let before: f64 = record.residual(c, &prediction.series[c]).iter().map(|x| x * x).sum();
            let after: f64 = left(r, &prediction, c).iter().map(|x| x * x).sum();
            let misfit = scored.misfits[r][c];
            let rest = misfit * (after / before.max(f64::MIN_POSITIVE)).min(1.0);
            evidence +=
                0.5 * share * task.weights.looks[r][c] * ((misfit + QUIET) / (rest.max(QUIET) + QUIET)).ln();
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
    Rung {
        place: place.name(),
        evidence,
        rms_n,
        goes_with,
        portrait: points.into_iter().step_by(thin).collect(),
    }
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

/// The part of the missing force that is due to noise.
pub(crate) fn noise_force(task: &Task<'_>, scored: &Scored, records: &[usize]) -> f64 {
    let mass = moving_mass(task.dataset, scored);
    let (mut sum, mut rows) = (0.0, 0.0);
    for &r in records {
        let Some(prediction) = task.predict(&scored.fitted.model, &scored.fitted.theta, r) else { continue };
        let own = task.dataset.records[r].len() as f64;
        sum += own * (mass * noise_acceleration(task, r, prediction.omega)).powi(2);
        rows += own;
    }
    if rows > 0.0 { (sum / rows).sqrt() } else { 0.0 }
}

/// Shapes in the force that is missing even with the accepted effects, in words: drag that differs by
/// direction, and waves over position with two periods within the stroke. Both must also explain the check
/// experiments, from which they were not estimated.
pub(crate) fn what_is_left(task: &Task<'_>, scored: &Scored) -> Vec<String> {
    let checks: Vec<usize> =
        (0..task.dataset.records.len()).filter(|&r| task.dataset.records[r].is_check).collect();
    let [mut seen, mut unseen] =
        [task.fitted.as_slice(), checks.as_slice()].map(|records| in_free_motion(task, scored, records));
    let is_rotational = task.dataset.machine.axis == Axis::Rotational;
    let mut said = Vec::new();
    // Drag comes first: in a periodic motion it would look periodic in position.
    let by_direction = slope(&seen);
    let share = [&seen, &unseen]
        .map(|points| taken_out(points, |p| by_direction * p.speed))
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    if share > LEAST_WAVE {
        said.push(format!(
            "viscous friction that is {:.1} {} larger in one direction is left ({:.0} % of what is missing)",
            2.0 * by_direction.abs(),
            Dimension::DAMPING.si_unit(is_rotational),
            100.0 * share
        ));
        seen.iter_mut().chain(&mut unseen).for_each(|p| p.force_n -= by_direction * p.speed);
    }
    let over_position: Vec<(f64, f64)> = seen.iter().map(|p| (p.position, p.force_n)).collect();
    let (low, high) = over_position
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (x, _)| (l.min(*x), h.max(*x)));
    for ForceRipple { amplitude, pitch, phase, .. } in ripples(&over_position) {
        let at = |p: &Missing| amplitude * (TAU * p.position / pitch + phase).sin();
        // If a drive is homed again, the phase of the wave changes.
        let share = taken_out(&seen, at).min(share_at(&unseen, pitch));
        if share > LEAST_WAVE && pitch * LEAST_PERIODS <= high - low {
            said.push(format!(
                "a {} periodic in position, pitch {}, is left ({:.0} % of what is missing)",
                if is_rotational {
                    format!("torque of {amplitude:.2} N m")
                } else {
                    format!("force of {amplitude:.2} N")
                },
                if is_rotational { format!("{pitch:.3} rad") } else { format!("{:.2} mm", 1e3 * pitch) },
                100.0 * share
            ));
        }
    }
    said
}

/// The missing force at one instant, and the motion without the means over its record.
struct Missing {
    position: f64,
    /// Magnitude of the velocity, without its mean.
    speed: f64,
    force_n: f64,
}

/// Missing force in free motion.
fn in_free_motion(task: &Task<'_>, scored: &Scored, records: &[usize]) -> Vec<Missing> {
    let points = portrait(task, scored, records, 2, Some(false));
    let mean =
        |of: &dyn Fn(&[f64; 4]) -> f64| points.iter().map(of).sum::<f64>() / points.len().max(1) as f64;
    let (speed, force) = (mean(&|p| p[1].abs()), mean(&|p| p[3]));
    points
        .iter()
        .map(|p| Missing { position: p[0], speed: p[1].abs() - speed, force_n: p[3] - force })
        .collect()
}

/// Slope of the missing force over the magnitude of the velocity, by least squares; zero without motion.
fn slope(points: &[Missing]) -> f64 {
    let sum = |of: &dyn Fn(&Missing) -> f64| points.iter().map(of).sum::<f64>();
    let square = sum(&|p| p.speed * p.speed);
    if square > 0.0 { sum(&|p| p.speed * p.force_n) / square } else { 0.0 }
}

/// Share of the variance of the missing force that the fixed `shape` explains.
fn taken_out(points: &[Missing], shape: impl Fn(&Missing) -> f64) -> f64 {
    let before: f64 = points.iter().map(|p| p.force_n.powi(2)).sum();
    let after: f64 = points.iter().map(|p| (p.force_n - shape(p)).powi(2)).sum();
    if before > 0.0 { 1.0 - after / before } else { 0.0 }
}

/// Share of the variance of the missing force that a wave of this pitch explains, with any phase.
fn share_at(points: &[Missing], pitch: f64) -> f64 {
    let waves = [f64::sin, f64::cos]
        .map(|wave| points.iter().map(|p| wave(TAU * p.position / pitch)).collect::<Vec<f64>>());
    explained(&waves, &points.iter().map(|p| p.force_n).collect::<Vec<f64>>())
}

/// Share of the missing force's variance that depends on position, velocity, drive force and time.
fn shares(points: &[PortraitPoint]) -> [(&'static str, f64); 4] {
    let column = |f: &dyn Fn(&PortraitPoint) -> f64| points.iter().map(f).collect::<Vec<f64>>();
    let largest = |f: &dyn Fn(&PortraitPoint) -> f64| points.iter().map(|p| f(p).abs()).fold(1e-12, f64::max);
    let missing = column(&|p| p.missing_n);
    if missing.len() < 20 {
        return [("position", 0.0), ("velocity", 0.0), ("drive force", 0.0), ("time", 0.0)];
    }
    let (span, fast, push, end) = (
        largest(&|p| p.position_m),
        largest(&|p| p.velocity_m_per_s),
        largest(&|p| p.drive_n),
        largest(&|p| p.time_s),
    );
    let powers =
        |f: &dyn Fn(&PortraitPoint) -> f64| (1..=4).map(|n| column(&|p| f(p).powi(n))).collect::<Vec<_>>();
    let bends = |f: &dyn Fn(&PortraitPoint) -> f64| {
        vec![
            column(f),
            column(&|p| f(p).signum()),
            column(&|p| f(p) * f(p).abs()),
            column(&|p| (f(p) / 0.05).tanh()),
        ]
    };
    [
        ("position", explained(&powers(&|p| p.position_m / span), &missing)),
        ("velocity", explained(&bends(&|p| p.velocity_m_per_s / fast), &missing)),
        ("drive force", explained(&bends(&|p| p.drive_n / push), &missing)),
        ("time", explained(&powers(&|p| p.time_s / end), &missing)),
    ]
}
