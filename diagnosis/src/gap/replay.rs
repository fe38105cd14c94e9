//! Replay: predictions of every column of a dataset for a machine with the recorded commands, and their
//! errors.

use feeler_plant::description::Machine;
use rayon::prelude::*;
use serde::Serialize;

use crate::budget::{Budget, Stage};
use crate::dataset::{Dataset, Record};
use crate::error::DiagnosisError;
use crate::fit::model::assemble_for;
use crate::predict::{Anchoring, Predictor, Start};

/// Length of the short predictions, s; a diagnosis measures the gap over the same length.
pub const WINDOW_S: f64 = 0.05;

/// Error of a prediction of one column.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnError {
    /// Name of the column in the dataset.
    pub column: String,
    /// Root mean square variation of the column over the experiment, signal units.
    pub scale: f64,
    /// Root mean square error of the free prediction from the first row, signal units.
    pub rms: f64,
    /// Ratio of `rms` to `scale`; infinite (`null` in JSON) if the column never changes.
    pub relative: f64,
    /// Largest error of the free prediction, signal units.
    pub largest: f64,
    /// Root mean square error over the scale if the prediction restarts every 50 ms from the measured motion.
    pub relative_in_windows: f64,
}

/// One experiment, predicted.
#[derive(Clone, Debug, Serialize)]
pub struct Replay {
    /// File of the experiment.
    pub experiment: String,
    /// Whether the experiment was set aside for scoring.
    pub is_check: bool,
    /// Errors by column.
    pub errors: Vec<ColumnError>,
    /// Index of the experiment in the dataset.
    #[serde(skip)]
    pub record: usize,
    /// Free prediction from the first row, one series per channel.
    #[serde(skip)]
    pub free: Vec<Vec<f64>>,
    /// Prediction that starts again every [`WINDOW_S`] from the measured motion.
    #[serde(skip)]
    pub windows: Vec<Vec<f64>>,
}

impl Replay {
    /// Name of the file with the predictions: CSV, whatever the format of the experiment.
    pub fn csv_name(&self) -> String {
        let stem = self.experiment.rsplit_once('.').map_or(self.experiment.as_str(), |(stem, _)| stem);
        format!("{stem}.csv")
    }

    /// The predicted columns under their own names and time stamps, with the recorded commands.
    pub fn csv(&self, dataset: &Dataset) -> String {
        let record = &dataset.records[self.record];
        let commands = dataset.drives.iter().map(|driven| &driven.column);
        let names = commands.chain(dataset.channels.iter().map(|channel| &channel.column));
        let mut text = std::iter::once("t_s").chain(names.map(String::as_str)).collect::<Vec<_>>().join(",");
        text.push('\n');
        for (k, t_s) in record.times_s.iter().enumerate() {
            let cells = record.commands.iter().chain(&self.free).map(|column| column[k].to_string());
            text += &std::iter::once(t_s.to_string()).chain(cells).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        text
    }
}

/// Simulates a machine with a dataset's recorded commands: once freely from the first row, and in short
/// windows that start from the measured motion.
///
/// The machine needs the elements that the dataset's channels read. Use the dataset's own machine, one from
/// its diagnosis, or load the dataset for the machine with [`Dataset::load_for`].
///
/// # Errors
/// If the machine has no motion.
pub fn replay(machine: &Machine, dataset: &Dataset) -> Result<Vec<Replay>, DiagnosisError> {
    (0..dataset.records.len()).into_par_iter().map(|r| replay_record(machine, dataset, r)).collect()
}

/// Simulates one experiment, given by its index, as [`replay`] does.
///
/// # Errors
/// If the machine has no motion.
pub fn replay_record(machine: &Machine, dataset: &Dataset, index: usize) -> Result<Replay, DiagnosisError> {
    replay_within(machine, dataset, index, Budget::unlimited())
}

/// Simulates one experiment until the time budget of a report is over.
pub(crate) fn replay_within(
    machine: &Machine,
    dataset: &Dataset,
    index: usize,
    budget: Budget,
) -> Result<Replay, DiagnosisError> {
    let record = &dataset.records[index];
    let assembly = assemble_for(machine.clone(), record.engagement)
        .map_err(|problems| DiagnosisError::Machine { problems })?;
    let mut predictor = Predictor::new(assembly, dataset, record)?.until(budget, Stage::Report);
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

/// Largest relative error; larger errors and diverging runs count as this.
const MOST_ERROR: f64 = 1e6;
/// A free run is worse than another one if its error is larger by this factor.
pub(crate) const WORSE: f64 = 1.05;

/// Errors of free runs from the first row, over the scale of each column, of the believed and of the repaired
/// machine. Each is a root mean square over the check experiments. `None` if the believed machine has no
/// motion.
pub fn free_runs(dataset: &Dataset, repaired: &Machine) -> Option<[f64; 2]> {
    let of = |machine: &Machine| free_run(dataset, machine, Budget::unlimited());
    Some([of(&dataset.machine)?, of(repaired).unwrap_or(MOST_ERROR)])
}

/// Error of one machine's free runs; `None` if it has no motion, or if the time ran out.
pub(crate) fn free_run(dataset: &Dataset, machine: &Machine, budget: Budget) -> Option<f64> {
    let checks: Vec<usize> = (0..dataset.records.len()).filter(|&r| dataset.records[r].is_check).collect();
    let errors: Option<Vec<Vec<f64>>> =
        checks.into_par_iter().map(|r| free_errors(dataset, machine, r, budget)).collect();
    root_mean_square(&errors?.concat())
}

/// The first experiment on which a machine's free run is clearly worse than another's, with both errors.
pub(crate) fn strays(
    dataset: &Dataset,
    machine: &Machine,
    other: &Machine,
    budget: Budget,
) -> Option<(usize, [f64; 2])> {
    let of = |r: usize| {
        let error = |machine: &Machine| {
            free_errors(dataset, machine, r, budget).and_then(|errors| root_mean_square(&errors))
        };
        let given = error(other)?;
        let own = error(machine).unwrap_or(MOST_ERROR);
        (own > WORSE * given).then_some((r, [own, given]))
    };
    (0..dataset.records.len()).into_par_iter().find_map_first(of)
}

/// Errors of a free run over one experiment for each column that varies, over its scale; `None` if the
/// machine has no motion, or if the time ran out.
fn free_errors(dataset: &Dataset, machine: &Machine, r: usize, budget: Budget) -> Option<Vec<f64>> {
    let record = &dataset.records[r];
    let assembly = assemble_for(machine.clone(), record.engagement).ok()?;
    let predictor = Predictor::new(assembly, dataset, record).ok()?;
    let free = predictor.until(budget, Stage::RunFreely).free().ok()?.series;
    let error = |c: usize| column_error(dataset, record, c, &free[c], &free[c]).relative.min(MOST_ERROR);
    Some((0..free.len()).map(error).filter(|error| !error.is_nan()).collect())
}

fn root_mean_square(errors: &[f64]) -> Option<f64> {
    let mean_square = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    (!errors.is_empty()).then(|| mean_square.sqrt())
}

fn column_error(dataset: &Dataset, record: &Record, c: usize, free: &[f64], windows: &[f64]) -> ColumnError {
    let measured = record.readings(c);
    let n = measured.len() as f64;
    let mean = measured.iter().sum::<f64>() / n;
    let rms = |predicted: &[f64]| {
        let squares = record.read_rows(c).map(|k| (record.series[c][k] - predicted[k]).powi(2));
        (squares.sum::<f64>() / n).sqrt()
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
        largest: record.read_rows(c).map(|k| (record.series[c][k] - free[k]).abs()).fold(0.0, f64::max),
        relative_in_windows: over_scale(rms(windows)),
    }
}
