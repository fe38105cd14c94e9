//! The findings and datasets of an import, for programs.

use feeler_diagnosis::import::{
    Chosen, ColumnRole, ColumnSummary, Guess, RunSummary, Survey, TableSummary, UnitGuess, Written,
};
use serde::Serialize;

/// Contents of logs, and the datasets made of them. The book shows the comments.
#[derive(Serialize)]
pub(super) struct Imported<'a> {
    /// The runs of the logs.
    runs: Vec<ImportedRun<'a>>,
    /// The joints that were recognised.
    joints: Vec<ImportedJoint<'a>>,
    /// Datasets that were written; none without `--out`.
    datasets: Vec<ImportedDataset<'a>>,
    /// Failures, a sentence each.
    notes: &'a [String],
}

/// A run.
#[derive(Serialize)]
struct ImportedRun<'a> {
    /// Its name.
    name: &'a str,
    /// Its tables.
    tables: Vec<ImportedTable<'a>>,
    /// Omissions and assumptions, a sentence each.
    notes: &'a [String],
}

/// A table.
#[derive(Serialize)]
struct ImportedTable<'a> {
    /// Topic or file; empty if it has the name of the run.
    name: &'a str,
    /// The file.
    file: &'a str,
    /// Number of rows.
    rows: usize,
    /// Time from the first row to the last.
    duration_s: f64,
    /// Rows per second; `None` without a clock.
    rate_hz: Option<f64>,
    /// Number of rows that are missing.
    lost_rows: usize,
    /// Longest stretch of missing rows.
    longest_loss_s: f64,
    /// Row of the file in which the clock goes back; `None` if it does not.
    back_in_row: Option<usize>,
    /// The clock; `None` if no column is one.
    clock: Option<ImportedClock<'a>>,
    /// Its columns.
    columns: Vec<ImportedColumn<'a>>,
}

/// A clock.
#[derive(Serialize)]
struct ImportedClock<'a> {
    /// Name of its column.
    column: &'a str,
    /// Its unit: `s`, `ms`, `us` or `ns`.
    unit: &'a str,
    /// Reason for this choice.
    why: &'a str,
}

/// A column.
#[derive(Serialize)]
struct ImportedColumn<'a> {
    /// Its name in the run.
    name: &'a str,
    /// Number of rows with a value.
    values: usize,
    /// Smallest value; `None` without values.
    least: Option<f64>,
    /// Largest value; `None` without values.
    most: Option<f64>,
    /// Its role: `target`, `target-velocity`, `feed-forward`, `position`, `velocity`, `effort` or
    /// `command`; `None` if it has none.
    role: Option<&'static str>,
}

/// A joint.
#[derive(Serialize)]
struct ImportedJoint<'a> {
    /// Its name in the log; empty in a log of one axis.
    joint: &'a str,
    /// The columns with a role.
    columns: Vec<ImportedRole<'a>>,
    /// Time by which the position follows the target; `None` unless both vary.
    lag_s: Option<f64>,
    /// Correlation of target and position at this lag; `None` without it.
    correlation: Option<f64>,
}

/// A column with a role.
#[derive(Serialize)]
struct ImportedRole<'a> {
    /// The role.
    role: &'static str,
    /// Name of the column.
    column: &'a str,
    /// Reason for this choice.
    why: &'a str,
    /// Apparent unit, `counts` for counts of an encoder; `None` for SI.
    unit: Option<&'a str>,
    /// Angle of one count (rad); `None` for other units.
    rad_per_count: Option<f64>,
    /// Reason for the unit; `None` for SI.
    why_unit: Option<&'a str>,
}

/// A dataset that was written.
#[derive(Serialize)]
struct ImportedDataset<'a> {
    /// Its folder.
    folder: String,
    /// The joint, by its name in the log.
    joint: &'a str,
    /// Files of its experiments.
    experiments: &'a [String],
    /// Assumptions about the machine, a sentence each.
    assumptions: &'a [String],
}

impl<'a> Imported<'a> {
    pub(super) fn new(survey: &'a Survey) -> Self {
        Self {
            runs: survey.runs.iter().map(ImportedRun::new).collect(),
            joints: survey.joints.iter().map(|(joint, guess)| ImportedJoint::new(joint, guess)).collect(),
            datasets: survey.datasets.iter().map(ImportedDataset::new).collect(),
            notes: &survey.notes,
        }
    }
}

impl<'a> ImportedRun<'a> {
    fn new(run: &'a RunSummary) -> Self {
        let tables = run.tables.iter().map(ImportedTable::new).collect();
        Self { name: &run.name, tables, notes: &run.notes }
    }
}

impl<'a> ImportedTable<'a> {
    fn new(table: &'a TableSummary) -> Self {
        let (lost_rows, longest_loss_s) = table.lost;
        Self {
            name: &table.name,
            file: &table.file,
            rows: table.rows,
            duration_s: table.duration_s,
            rate_hz: table.rate_hz,
            lost_rows,
            longest_loss_s,
            back_in_row: table.back_in_row,
            clock: table.clock.as_ref().map(|(column, unit, why)| ImportedClock { column, unit, why }),
            columns: table.columns.iter().map(ImportedColumn::new).collect(),
        }
    }
}

impl<'a> ImportedColumn<'a> {
    fn new(column: &'a ColumnSummary) -> Self {
        let bound = |end: usize| Some(column.range[end]).filter(|_| column.present > 0);
        Self {
            name: &column.name,
            values: column.present,
            least: bound(0),
            most: bound(1),
            role: column.role.as_ref().map(|(role, ..)| role.noun()),
        }
    }
}

impl<'a> ImportedJoint<'a> {
    fn new(joint: &'a str, guess: &'a Guess) -> Self {
        Self {
            joint,
            columns: guess.columns.iter().map(|(role, chosen)| ImportedRole::new(*role, chosen)).collect(),
            lag_s: guess.follow.map(|follow| follow.lag_s),
            correlation: guess.follow.map(|follow| follow.correlation),
        }
    }
}

impl<'a> ImportedRole<'a> {
    fn new(role: ColumnRole, chosen: &'a Chosen) -> Self {
        let (unit, rad_per_count) = match &chosen.unit {
            Some((UnitGuess::Symbol(symbol), _)) => (Some(symbol.as_ref()), None),
            Some((UnitGuess::Counts(each), _)) => (Some("counts"), Some(*each)),
            None => (None, None),
        };
        Self {
            role: role.noun(),
            column: &chosen.column,
            why: &chosen.why,
            unit,
            rad_per_count,
            why_unit: chosen.unit.as_ref().map(|(_, why)| why.as_str()),
        }
    }
}

impl<'a> ImportedDataset<'a> {
    fn new(written: &'a Written) -> Self {
        Self {
            folder: written.folder.display().to_string(),
            joint: &written.joint,
            experiments: &written.experiments,
            assumptions: &written.assumptions,
        }
    }
}
