//! Summary of a run.

use std::collections::HashMap;

use feeler_logs::{Run, Table};
use indexmap::IndexMap;

use super::guess::Guess;
use super::role::ColumnRole;

/// A run.
#[derive(Clone, Debug)]
pub struct RunSummary {
    /// Its name.
    pub name: String,
    /// Its tables.
    pub tables: Vec<TableSummary>,
    /// Omissions and assumptions.
    pub notes: Vec<String>,
}

/// A table.
#[derive(Clone, Debug)]
pub struct TableSummary {
    /// Topic or file.
    pub name: String,
    /// The file.
    pub file: String,
    /// Rows.
    pub rows: usize,
    /// Length, s.
    pub duration_s: f64,
    /// Rows per second.
    pub rate_hz: Option<f64>,
    /// Number of missing rows, and the longest stretch, s.
    pub lost: (usize, f64),
    /// Row of the file in which the clock goes back.
    pub back_in_row: Option<usize>,
    /// The clock: column, unit, reason.
    pub clock: Option<(String, &'static str, String)>,
    /// The columns.
    pub columns: Vec<ColumnSummary>,
}

/// A column.
#[derive(Clone, Debug)]
pub struct ColumnSummary {
    /// Its name in the run.
    pub name: String,
    /// Rows that have a value.
    pub present: usize,
    /// Smallest and largest value.
    pub range: [f64; 2],
    /// Its assumed role: the role, the joint, the reason.
    pub role: Option<(ColumnRole, String, String)>,
}

pub(super) fn of(run: &Run, guesses: &IndexMap<String, Guess>) -> RunSummary {
    let mut roles: HashMap<&str, (ColumnRole, String, String)> = HashMap::new();
    for (joint, guess) in guesses {
        for (role, chosen) in &guess.columns {
            roles.insert(&chosen.column, (*role, joint.clone(), chosen.why.clone()));
        }
    }
    let mut names = run.names().into_iter();
    let tables = run.tables.iter().map(|table| {
        let columns = table.columns.iter().map(|column| {
            let name = names.next().unwrap_or_default();
            let values = || column.values.iter().copied().filter(|x| x.is_finite());
            let range = values().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)]);
            let role = roles.get(name.as_str()).cloned();
            ColumnSummary { present: column.present(), range, role, name }
        });
        TableSummary {
            name: table.name.clone(),
            file: table.file.display().to_string(),
            rows: table.rows(),
            duration_s: duration(table),
            rate_hz: table.rate_hz(),
            lost: lost(table),
            back_in_row: table.goes_back_at().map(|row| table.rows_before + row + 1),
            clock: table.clock.as_ref().map(|c| (c.column.clone(), c.unit.symbol(), c.why.clone())),
            columns: columns.collect(),
        }
    });
    RunSummary { name: run.name.clone(), tables: tables.collect(), notes: run.notes.clone() }
}

fn duration(table: &Table) -> f64 {
    table.times_s.first().zip(table.times_s.last()).map_or(0.0, |(first, last)| last - first)
}

/// Missing rows, from row distances that are whole multiples of the usual one.
fn lost(table: &Table) -> (usize, f64) {
    let Some(rate_hz) = table.rate_hz() else { return (0, 0.0) };
    let mut lost = (0_usize, 0.0_f64);
    for pair in table.times_s.windows(2) {
        let missing = ((pair[1] - pair[0]) * rate_hz).round() - 1.0;
        if missing >= 1.0 {
            lost = (lost.0.saturating_add(missing as usize), lost.1.max(missing / rate_hz));
        }
    }
    lost
}
