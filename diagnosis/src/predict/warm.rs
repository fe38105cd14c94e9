//! The heat that a record leaves in windings.

use feeler_plant::assembly::{Assembly, Drive};

use crate::dataset::{Dataset, Record};

/// The heat of every drive's winding after a record, zero without one, if their forces are their commands. It
/// goes on by an exponential from row to row; delays and lags are short against a warming. `None` if a force
/// depends on the motion.
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
        // A drive without commands rests.
        let rows = commands.iter().chain(std::iter::repeat(&0.0)).take(record.len());
        Some(rows.fold(winding.heat, next))
    };
    assembly.drives.iter().enumerate().map(heat).collect()
}
