//! Features of records from which fits start.

use feeler_plant::assembly::Source;
use feeler_plant::description::{Engagement, Quantity};

use crate::dataset::{Dataset, Record};
use crate::fit::least_squares::Task;
use crate::fit::missing::{missing_acceleration, moving_mass};
use crate::fit::scored::Scored;
use crate::kinds::Glance;
use crate::predict::Prediction;

/// Simple features of the records, and the force that the calibrated machine lacks.
pub(crate) fn glance(task: &Task<'_>, calibrated: &Scored) -> Glance {
    let dataset = task.dataset;
    let largest = |series: &[f64]| series.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let mut glance = Glance::default();
    let mut depths: Vec<Vec<f64>> = vec![Vec::new(); dataset.machine.contacts.len()];
    for (r, record) in dataset.records.iter().enumerate() {
        glance.spacing_s = record.spacing_s;
        let duration_s: f64 = record.earlier().chain([record]).map(Record::duration_s).sum();
        glance.duration_s = glance.duration_s.max(duration_s);
        let mut is_pushed = true;
        for (driven, command) in dataset.drives.iter().zip(&record.commands) {
            let is_force = dataset.is_forced(driven.drive);
            is_pushed &= is_force;
            glance.asked = glance.asked.max(largest(command));
            glance.command = if is_force { glance.command.max(largest(command)) } else { glance.command };
            let changes: Vec<f64> = command.windows(2).map(|w| w[1] - w[0]).collect();
            glance.command_change = glance.command_change.max(largest(&changes));
        }
        for (channel, series) in dataset.channels.iter().zip(&record.series) {
            if channel.quantity(&dataset.machine).is_force() {
                glance.force = glance.force.max(largest(series));
            }
        }
        let Some(prediction) = task.predict(&calibrated.fitted.model, &calibrated.fitted.theta, r) else {
            continue;
        };
        if !is_pushed {
            let forces: Vec<f64> = prediction.stroke.iter().map(|stroke| stroke[2]).collect();
            glance.command = glance.command.max(largest(&forces));
        }
        glance.speed = prediction.stroke.iter().map(|s| s[1].abs()).fold(glance.speed, f64::max);
        if !record.is_check {
            let mass = moving_mass(dataset, calibrated);
            let residual = missing_acceleration(dataset, r, &prediction);
            let positions = positions(dataset, calibrated, r, &prediction);
            glance.missing.extend(positions.into_iter().zip(residual).map(|(x, a)| (x, mass * a)));
            for (contact, depths) in depths.iter_mut().enumerate() {
                depths.extend(excess_depths(dataset, record, &prediction, contact));
            }
        }
    }
    for spring in 0..dataset.machine.springs.len() {
        glance.elongations.extend(elongation(dataset, spring).map(|range| (spring, range)));
    }
    for (contact, depths) in depths.iter_mut().enumerate() {
        depths.sort_by(f64::total_cmp);
        glance.surfaces.extend(depths.get(depths.len() / 2).map(|middle| (contact, *middle)));
    }
    for (c, channel) in dataset.channels.iter().enumerate() {
        let Source::Sensor(sensor) = channel.source else { continue };
        let step = dataset.grain(c);
        if step > 0.0 {
            glance.quanta.push((sensor, step));
        }
    }
    glance
}

/// Positions of the first drive at each row of a record: the predicted ones, corrected by the residual of an
/// encoder on what it moves rigidly. A machine that lacks a stop is predicted far beyond it.
fn positions(dataset: &Dataset, scored: &Scored, record: usize, prediction: &Prediction) -> Vec<f64> {
    let record = &dataset.records[record];
    let encoder = || {
        let assembly = scored.fitted.model.assembly(&scored.fitted.theta, record.engagement)?;
        let on = assembly.drives[dataset.drives.first()?.drive].on;
        let moved = assembly.reached(vec![on], &[], |link| link.rigid);
        let is_read = |c: &usize| {
            let read = assembly.node_read(dataset.channels[*c].source);
            read.is_some_and(|(node, _, quantity)| quantity == Quantity::Position && moved.contains(&node))
                && !record.silent[*c]
        };
        let c = (0..dataset.channels.len()).find(is_read)?;
        Some((record.residual(c, &prediction.series[c]), dataset.channels[c].scale(&assembly).0))
    };
    let rows = prediction.stroke.iter().map(|stroke| stroke[0]);
    match encoder() {
        Some((residual, gain)) => rows.zip(residual).map(|(x, residual)| x + residual / gain).collect(),
        None => rows.collect(),
    }
}

/// Share of the rows that is cut off at either end of a range, because of noise and impacts.
const OUTSIDE: f64 = 0.02;

/// Range of the measured elongation of a spring; `None` unless sensors read the positions of both its bodies.
fn elongation(dataset: &Dataset, spring: usize) -> Option<f64> {
    let (_, spring) = dataset.machine.springs.get_index(spring)?;
    let [a, b] = spring.between.each_ref().map(|body| {
        dataset.channels.iter().position(|channel| {
            let Source::Sensor(sensor) = channel.source else { return false };
            let reads = &dataset.machine.sensors[sensor].reads;
            reads.element == *body && reads.quantity == Quantity::Position
        })
    });
    let (a, b) = (a?, b?);
    // Encoders may be zeroed before each record.
    let counts = |record: &&Record| !record.is_check && !record.silent[a] && !record.silent[b];
    dataset.records.iter().filter(counts).filter_map(|record| range(record, [a, b])).reduce(f64::max)
}

/// Range of the difference of two columns of a record.
fn range(record: &Record, [a, b]: [usize; 2]) -> Option<f64> {
    let mut elongations: Vec<f64> =
        record.series[b].iter().zip(&record.series[a]).map(|(b, a)| b - a).collect();
    elongations.sort_by(f64::total_cmp);
    let last = elongations.len().checked_sub(1)?;
    let outside = (OUTSIDE * last as f64) as usize;
    Some(elongations[last - outside] - elongations[outside])
}

/// A force below this multiple of its noise counts as zero.
const COARSEST_TOUCH: f64 = 20.0;
/// Share of a record's largest contact force above which the contact is surely closed.
const PRESSED: f64 = 0.3;

/// Penetration of a contact beyond that of the measured force, one value for every row of a record with a
/// closed contact, m.
fn excess_depths(dataset: &Dataset, record: &Record, prediction: &Prediction, contact: usize) -> Vec<f64> {
    let Some((name, believed)) = dataset.machine.contacts.get_index(contact) else { return Vec::new() };
    let parts = record.engagement.unwrap_or(believed.engagement) == Engagement::Unilateral;
    let reads = |source: Source| match source {
        Source::Sensor(i) => {
            let reads = &dataset.machine.sensors[i].reads;
            reads.element == *name && reads.quantity.is_force()
        }
        source => {
            matches!(source, Source::Contact(c, quantity) if c == contact && quantity.is_force())
        }
    };
    let (Some(c), true) = (dataset.channels.iter().position(|channel| reads(channel.source)), parts) else {
        return Vec::new();
    };
    let force = &record.series[c];
    let pressed = PRESSED * force.iter().copied().fold(COARSEST_TOUCH * dataset.channels[c].noise, f64::max);
    let rows = force.iter().zip(&prediction.compressions[contact]).filter(|(force, _)| **force > pressed);
    rows.map(|(force, depth)| depth - force / believed.stiffness).collect()
}
