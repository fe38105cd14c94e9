//! Motions that a record imposes on bodies.

use std::sync::Arc;

use feeler_engine::knots;
use feeler_plant::assembly::{Assembly, Source};
use feeler_plant::description::{Profile, Quantity};

use crate::dataset::{Dataset, Driven, Record};

/// Gives every imposed motion the positions of a record. If a column measures the body's own speed, it gives
/// the speed at each row. Otherwise the speed follows from the rows before and after.
pub(super) fn impose(assembly: &mut Assembly, dataset: &Dataset, record: &Record) {
    for (&Driven { drive, .. }, commands) in dataset.drives.iter().zip(&record.commands) {
        let part = &mut assembly.drives[drive];
        if part.imposed.is_none() {
            continue;
        }
        let at = |row: usize| (row as f64 * record.spacing_s + part.delay, part.held(commands[row]));
        let points: Vec<(f64, f64)> = (0..commands.len()).map(at).collect();
        let mut knots = knots(&points);
        let of_body = Source::Node(part.on, Quantity::Velocity);
        let measured = dataset.channels.iter().position(|channel| channel.source == of_body);
        // A dead band stops the motion at times, which the measured speed does not show.
        if let Some(c) = measured.filter(|c| !record.silent[*c] && part.deadband == 0.0) {
            for (k, speed) in record.series[c].iter().enumerate().filter(|(k, _)| !record.is_bridged(c, *k)) {
                knots[k].rate_m_per_s = part.gain * speed;
            }
        }
        if let Ok(profile) = Profile::new(&knots) {
            part.imposed = Some(Arc::new(profile));
        }
    }
}
