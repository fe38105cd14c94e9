//! Reads the columns of an experiment's file at common instants, for every file format.

use std::path::Path;

use feeler_files::{ColumnSpec, DatasetFile, LogClock};
use feeler_logs::{ClockUnit, LogError, Pick, Run, on_one_grid, read_file};
use indexmap::IndexMap;

use super::data::FileRows;
use crate::error::DiagnosisError;

/// Name of the time column if the file states only a rate.
const TIME: &str = "t_s";

/// Reads the columns of a dataset from a file; `held` names those that hold their value between readings.
pub(super) fn table(dataset: &DatasetFile, path: &Path, held: &[&str]) -> Result<FileRows, DiagnosisError> {
    let mut runs = read_file(path, dataset.clock.map(unit_of))?;
    if runs.len() > 1 {
        return Err(DiagnosisError::Unreadable {
            file: path.to_owned(),
            reason: format!("it holds {} episodes", runs.len()),
            remedy: "`feeler import` writes a file for each of them",
        });
    }
    let mut run = runs.pop().unwrap_or_default();
    if let Some(rate_hz) = dataset.rate_hz {
        run.set_rate(rate_hz);
    }
    let columns = &dataset.columns;
    let names: Vec<String> = columns.iter().map(|(name, column)| in_file(name, column)).collect();
    let found: Vec<(&String, &ColumnSpec, &str)> = (columns.iter().zip(&names))
        .filter(|(_, inside)| run.find(inside).is_some())
        .map(|((name, column), inside)| (name, column, inside.as_str()))
        .collect();
    let picks: Vec<Pick<'_>> = found
        .iter()
        .map(|(name, _, inside)| Pick { name: inside, is_held: held.contains(&name.as_str()) })
        .collect();
    let series = on_one_grid(path, &run, &picks)?;
    let mut table = FileRows {
        file: path.to_owned(),
        header: vec![series.clock],
        columns: vec![series.times_s],
        unreadable: vec![None],
        rows_before: series.rows_before,
        bridged: vec![Vec::new()],
        notes: series.notes,
    };
    for (((name, column, _), values), bad) in found.iter().zip(series.values).zip(series.bad) {
        table.header.push((*name).clone());
        table.columns.push(in_si(values, column));
        table.unreadable.push(bad);
    }
    table.bridged.extend(series.bridged);
    let others = others(&run, &found, columns);
    table.columns.extend(others.iter().map(|_| Vec::new()));
    table.unreadable.extend(others.iter().map(|_| None));
    table.header.extend(others);
    Ok(table)
}

fn unit_of(clock: LogClock) -> ClockUnit {
    match clock {
        LogClock::Seconds => ClockUnit::Seconds,
        LogClock::Milliseconds => ClockUnit::Milliseconds,
        LogClock::Microseconds => ClockUnit::Microseconds,
        LogClock::Nanoseconds => ClockUnit::Nanoseconds,
    }
}

/// Identifier of a column in a file: its number if stated, otherwise its name.
fn in_file(name: &str, column: &ColumnSpec) -> String {
    column.number.map_or_else(|| name.to_owned(), |number| number.to_string())
}

/// Names of columns that the dataset does not use.
fn others(
    run: &Run,
    found: &[(&String, &ColumnSpec, &str)],
    columns: &IndexMap<String, ColumnSpec>,
) -> Vec<String> {
    let is_used = |name: &String| found.iter().any(|(_, _, inside)| inside == name);
    run.names()
        .into_iter()
        .filter(|name| *name != TIME && !is_used(name) && !columns.contains_key(name))
        .collect()
}

fn in_si(mut values: Vec<f64>, column: &ColumnSpec) -> Vec<f64> {
    if column.is_si() {
        return values;
    }
    for value in &mut values {
        *value = *value * column.scale + column.offset;
    }
    values
}

impl From<LogError> for DiagnosisError {
    fn from(error: LogError) -> Self {
        Self::Log(error)
    }
}
