//! Heat of windings after a record.

use feeler_plant::assembly::{Assembly, Drive};

use crate::dataset::{Dataset, Record};

/// The heat of every drive's winding after a record, if its force equals its command; zero for drives without
/// a winding. Each row is one exponential step, because delays and lags are short against warming. `None` if
/// a force depends on the motion.
pub(super) fn by_commands(assembly: &Assembly, dataset: &Dataset, record: &Record) -> Option<Vec<f64>> {
    let heat = |(index, drive): (usize, &Drive)| {
        let Some(winding) = drive.warming else { return Some(0.0) };
        if !drive.commands_force() || drive.line.is_some() || dataset.is_looped(index) {
            return None;
        }
        let column = dataset.drives.iter().position(|driven| driven.drive == index);
        let commands = column.map_or(&[][..], |column| &record.commands[column]);
        let left = (-record.spacing_s / winding.time_constant).exp();
        let next = |heat: f64, command: &f64| {
            let end = (drive.received(*command) / winding.force).powi(2);
            end + (heat - end) * left
        };
        // A drive without commands is at rest.
        let rows = commands.iter().chain(std::iter::repeat(&0.0)).take(record.len());
        Some(rows.fold(winding.heat, next))
    };
    assembly.drives.iter().enumerate().map(heat).collect()
}
