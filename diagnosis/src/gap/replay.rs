//! A machine driven with what a dataset commanded: predictions of every column, and how far they are off.

use feeler_plant::description::Machine;
use rayon::prelude::*;
use serde::Serialize;

use crate::dataset::{Dataset, Record};
use crate::error::DiagnosisError;
use crate::fit::model::assemble_for;
use crate::predict::{Anchoring, Predictor, Start};

/// Length of the short predictions, s: the same as in the gap of a diagnosis.
pub const WINDOW_S: f64 = 0.05;

/// How far a prediction of one column is off.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnError {
    /// The column.
    pub column: String,
    /// Root mean square of its variation over the experiment, signal units.
    pub scale: f64,
    /// Root mean square error of the free prediction from the first row, signal units.
    pub rms: f64,
    /// The same over the scale; infinite (`null` in JSON) where the column never changes.
    pub relative: f64,
    /// Largest error of the free prediction, signal units.
    pub largest: f64,
    /// Root mean square error over the scale where the prediction starts again every [`WINDOW_S`] from the
    /// measured motion.
    pub relative_in_windows: f64,
}

/// One experiment, predicted.
#[derive(Clone, Debug, Serialize)]
pub struct Replay {
    /// The experiment's file.
    pub experiment: String,
    /// Whether it was set aside for scoring.
    pub is_check: bool,
    /// Errors by column.
    pub errors: Vec<ColumnError>,
    /// Position of the experiment in the dataset.
    #[serde(skip)]
    pub record: usize,
    /// Free prediction from the first row, one series per channel.
    #[serde(skip)]
    pub free: Vec<Vec<f64>>,
    /// Prediction that starts again every [`WINDOW_S`] from the measured motion.
    #[serde(skip)]
    pub windows: Vec<Vec<f64>>,
}

/// Drives a machine with a dataset's recorded commands: freely from the first row, and in short windows from
/// the measured motion.
///
/// The machine's elements must be those that the dataset's channels refer to: take the dataset's own machine,
/// one that came of its diagnosis, or load the dataset for the machine with [`Dataset::load_for`].
///
/// # Errors
/// Where the machine has no motion.
pub fn replay(machine: &Machine, dataset: &Dataset) -> Result<Vec<Replay>, DiagnosisError> {
    (0..dataset.records.len()).into_par_iter().map(|r| replay_record(machine, dataset, r)).collect()
}

/// The same for one experiment, by its position.
///
/// # Errors
/// Where the machine has no motion.
pub fn replay_record(machine: &Machine, dataset: &Dataset, index: usize) -> Result<Replay, DiagnosisError> {
    let record = &dataset.records[index];
    let assembly = assemble_for(machine.clone(), record.engagement)
        .map_err(|problems| DiagnosisError::Machine { problems })?;
    let mut predictor = Predictor::new(assembly, dataset, record)?;
    let free = predictor.free()?.series;
    let rows = ((WINDOW_S / record.spacing_s).round() as usize).max(1);
    let windows = predictor.follow(Anchoring::Continuous, Start::Windows(rows))?.series;
    let errors =
        (0..record.series.len()).map(|c| column_error(dataset, record, c, &free[c], &windows[c])).collect();
    Ok(Replay {
        experiment: record.name.clone(),
        is_check: record.is_check,
        errors,
        record: index,
        free,
        windows,
    })
}

fn column_error(dataset: &Dataset, record: &Record, c: usize, free: &[f64], windows: &[f64]) -> ColumnError {
    let measured = &record.series[c];
    let n = measured.len() as f64;
    let mean = measured.iter().sum::<f64>() / n;
    let rms = |predicted: &[f64]| {
        (measured.iter().zip(predicted).map(|(m, p)| (m - p).powi(2)).sum::<f64>() / n).sqrt()
    };
    let is_constant = measured.iter().all(|m| m.to_bits() == measured[0].to_bits());
    let scale =
        if is_constant { 0.0 } else { (measured.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / n).sqrt() };
    let over_scale = |error: f64| if scale > 0.0 { error / scale } else { f64::INFINITY };
    ColumnError {
        column: dataset.channels[c].column.clone(),
        scale,
        rms: rms(free),
        relative: over_scale(rms(free)),
        largest: measured.iter().zip(free).map(|(m, p)| (m - p).abs()).fold(0.0, f64::max),
        relative_in_windows: over_scale(rms(windows)),
    }
}
