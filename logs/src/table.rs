//! Numbers of a log: runs, tables, columns.

use std::path::PathBuf;

use crate::clock::Clock;

/// One recording: tables that belong together, on consistent clocks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Short name: that of the file or folder, with the number of the episode if there are several.
    pub name: String,
    pub tables: Vec<Table>,
    /// Omissions and assumptions, a sentence each.
    pub notes: Vec<String>,
}

/// Columns with a common clock: a topic, a file, or arrays of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Topic, or name of the file without its suffix; empty if the run has one table without a name.
    pub name: String,
    /// The file that holds it.
    pub file: PathBuf,
    /// The source of the times; `None` if the table has no clock.
    pub clock: Option<Clock>,
    /// Time of each row after the clock's origin, s; empty without a clock.
    pub times_s: Vec<f64>,
    /// Rows of the file before the first one with data.
    pub rows_before: usize,
    /// The columns; all have a value for each row.
    pub columns: Vec<Column>,
}

/// A column of numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// Header, field path or name of the array.
    pub name: String,
    /// Position in the file, from one: several columns share it if a cell is a list.
    pub number: usize,
    /// Unit, if the file states it.
    pub unit: Option<String>,
    /// A value for each row; NaN if the row has none.
    pub values: Vec<f64>,
    /// Cells with something other than a number.
    pub bad: Option<BadCells>,
}

/// Cells with something other than a number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadCells {
    /// Index of the first such row.
    pub first: usize,
    /// Number of such cells.
    pub count: usize,
}

impl Run {
    /// Gives a clock to tables without one, with rows at this rate.
    pub fn set_rate(&mut self, rate_hz: f64) {
        for table in self.tables.iter_mut().filter(|table| table.clock.is_none()) {
            table.times_s = (0..table.rows()).map(|row| row as f64 / rate_hz).collect();
            let why = format!("the rate of its rows is stated, {rate_hz} Hz");
            table.clock = Some(Clock {
                column: "row".into(),
                unit: crate::clock::ClockUnit::Seconds,
                origin_s: 0.0,
                why,
            });
        }
    }
}

impl Column {
    pub(crate) fn new(name: impl Into<String>, number: usize) -> Self {
        Self { name: name.into(), number, ..Self::default() }
    }

    /// Rows that have a value.
    pub fn present(&self) -> usize {
        self.values.iter().filter(|x| !x.is_nan()).count()
    }

    pub(crate) fn push_bad(&mut self) {
        let first = self.values.len();
        self.bad.get_or_insert(BadCells { first, count: 0 }).count += 1;
        self.values.push(f64::NAN);
    }
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(self.times_s.len(), |column| column.values.len())
    }

    /// Rows per second, from the median distance of rows; `None` without a clock or with fewer than two rows.
    pub fn rate_hz(&self) -> Option<f64> {
        crate::clock::median_step(&self.times_s).map(f64::recip)
    }

    /// Rows per second of one column, which may have fewer values than the table has rows.
    pub(crate) fn rate_of_hz(&self, column: &Column) -> Option<f64> {
        let own = self.times_s.iter().zip(&column.values).filter(|(_, x)| !x.is_nan());
        crate::clock::median_step(&own.map(|(t, _)| *t).collect::<Vec<f64>>()).map(f64::recip)
    }

    /// Name by which a column is found in its run.
    pub fn full_name(&self, column: &Column) -> String {
        match (self.name.is_empty(), column.name.is_empty()) {
            (true, _) => column.name.clone(),
            (_, true) => self.name.clone(),
            _ if column.name.starts_with('[') => format!("{}{}", self.name, column.name),
            _ => format!("{}.{}", self.name, column.name),
        }
    }

    pub(crate) fn shrink(&mut self) {
        self.times_s.shrink_to_fit();
        for column in &mut self.columns {
            column.values.shrink_to_fit();
        }
    }
}
