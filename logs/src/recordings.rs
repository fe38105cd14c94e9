//! Several recordings in one log: its clocks start again.

use std::ops::Range;

use crate::clock::median_step;
use crate::error::{LogError, LogPlace};
use crate::table::{BadCells, Column, Run, Table};

/// Most usual distances between the first two rows of a recording: a single wrong time begins none.
const NEXT_ROW: f64 = 4.0;

impl Run {
    /// The recordings of a log: several if the clocks of all its tables start again, equally often. A clock
    /// that goes back otherwise stays as it is.
    #[must_use]
    pub fn recordings(mut self) -> Vec<Self> {
        let starts: Vec<Vec<usize>> = self.tables.iter().map(Table::starts).collect();
        let count = starts.first().map_or(0, Vec::len);
        if count < 2 || starts.iter().any(|starts| starts.len() != count) {
            return vec![self];
        }
        self.notes.push(format!(
            "{}: the clock starts again in row {}: the log is read as {count} recordings, `{name}-1` to \
             `{name}-{count}`",
            self.tables[0].file.display(),
            self.tables[0].rows_before + starts[0][1] + 1,
            name = self.name
        ));
        let part = |i: usize| {
            let of = |(table, starts): (&Table, &Vec<usize>)| {
                table.part(starts[i]..starts.get(i + 1).copied().unwrap_or(table.rows()))
            };
            let notes = if i == 0 { self.notes.clone() } else { Vec::new() };
            let tables = self.tables.iter().zip(&starts).map(of).collect();
            Self { name: format!("{}-{}", self.name, i + 1), tables, notes }
        };
        (0..count).map(part).collect()
    }
}

impl Table {
    /// Index of the first row that is earlier than the row before.
    pub fn goes_back_at(&self) -> Option<usize> {
        self.times_s.windows(2).position(|pair| pair[1] < pair[0]).map(|row| row + 1)
    }

    /// Index of the first row that is not later than the row before.
    pub fn stays_at(&self) -> Option<usize> {
        self.times_s.windows(2).position(|pair| pair[1] <= pair[0]).map(|row| row + 1)
    }

    /// The error of the first row without a time.
    pub(crate) fn without_time(&self) -> Option<LogError> {
        let row = self.times_s.iter().position(|time| !time.is_finite())?;
        let what = format!("the clock `{}` holds no time here", self.clock.as_ref()?.column);
        let remedy = "correct this cell, or delete the row";
        Some(LogError::damaged(&self.file, LogPlace::Row(self.rows_before + row + 1), what, remedy))
    }

    /// The error of a row that is not later than the row before.
    pub fn out_of_order(&self, row: usize) -> LogError {
        let clock = self.clock.as_ref().map_or("row", |clock| clock.column.as_str());
        let what = match (row.checked_sub(1).and_then(|row| self.times_s.get(row)), self.times_s.get(row)) {
            (Some(before), Some(here)) if here < before => {
                format!("the clock `{clock}` goes back from {before} s to {here} s")
            }
            (Some(before), _) => format!("the clock `{clock}` does not advance beyond {before} s"),
            _ => format!("the clock `{clock}` does not advance"),
        };
        let remedy = "sort the rows by time, cut the file there, or repair the clock of the recorder";
        LogError::damaged(&self.file, LogPlace::Row(self.rows_before + row + 1), what, remedy)
    }

    /// First rows of the recordings of a table. If the clock goes back anywhere without starting again, there
    /// is one.
    fn starts(&self) -> Vec<usize> {
        let mut starts = vec![0];
        if self.goes_back_at().is_none() {
            return starts;
        }
        let Some(usual_s) = median_step(&self.times_s) else { return starts };
        let mut begun_s = self.times_s[0];
        for row in 1..self.times_s.len() {
            let here_s = self.times_s[row];
            if here_s >= self.times_s[row - 1] {
                continue;
            }
            let is_followed = self
                .times_s
                .get(row + 1)
                .is_some_and(|next_s| (0.0..=NEXT_ROW * usual_s).contains(&(next_s - here_s)));
            if here_s > begun_s + usual_s || !is_followed {
                return vec![0];
            }
            starts.push(row);
            begun_s = here_s;
        }
        starts
    }

    fn part(&self, rows: Range<usize>) -> Self {
        Self {
            name: self.name.clone(),
            file: self.file.clone(),
            clock: self.clock.clone(),
            times_s: self.times_s[rows.clone()].to_vec(),
            rows_before: self.rows_before + rows.start,
            columns: self.columns.iter().map(|column| column.part(rows.clone())).collect(),
        }
    }
}

impl Column {
    /// Some of its rows. Of cells with something other than a number only the first has a known row.
    fn part(&self, rows: Range<usize>) -> Self {
        let bad = self.bad.as_ref().filter(|bad| rows.contains(&bad.first));
        Self {
            name: self.name.clone(),
            number: self.number,
            unit: self.unit.clone(),
            bad: bad.map(|bad| BadCells { first: bad.first - rows.start, count: bad.count }),
            values: self.values[rows].to_vec(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(times_s: Vec<f64>) -> Run {
        let columns = vec![Column { values: times_s.clone(), ..Column::default() }];
        let (name, file) = (String::new(), "a.csv".into());
        let table = Table { name, file, clock: None, times_s, rows_before: 1, columns };
        Run { name: "a".into(), tables: vec![table], notes: Vec::new() }
    }

    fn rows(count: u32) -> impl Iterator<Item = f64> {
        (0..count).map(|k| 0.1 * f64::from(k))
    }

    #[test]
    fn truth_a_clock_that_starts_again_begins_a_recording() {
        let parts = run(rows(60).chain(rows(50)).chain(rows(70)).collect()).recordings();
        let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(names, ["a-1", "a-2", "a-3"]);
        let sizes = [60, 50, 70].map(|count| rows(count).collect::<Vec<f64>>());
        for (part, times) in parts.iter().zip(&sizes) {
            assert_eq!((&part.tables[0].times_s, &part.tables[0].columns[0].values), (times, times));
        }
        // A header and 60 rows stand before the second recording.
        assert_eq!(parts.iter().map(|part| part.tables[0].rows_before).collect::<Vec<_>>(), [1, 61, 111]);
        assert!(
            parts[0].notes[0].contains("a.csv: the clock starts again in row 62"),
            "{:?}",
            parts[0].notes
        );
    }

    #[test]
    fn truth_a_clock_that_only_goes_back_begins_none() {
        let back = rows(60).map(|t| if t > 3.0 { t - 1.05 } else { t });
        let glitch = rows(60).enumerate().map(|(k, t)| if k == 30 { 0.0 } else { t });
        for times in [back.collect::<Vec<f64>>(), glitch.collect(), rows(60).collect()] {
            let whole = run(times);
            assert_eq!(whole.clone().recordings(), [whole]);
        }
    }

    /// Two tables are cut only if both show the same recordings.
    #[test]
    fn truth_tables_of_one_run_are_cut_together_or_not_at_all() {
        let twice = || rows(60).chain(rows(60)).collect::<Vec<f64>>();
        let mut both = run(twice());
        both.tables.extend(run(rows(30).chain(rows(30)).collect()).tables);
        let parts = both.recordings();
        assert_eq!(parts.len(), 2);
        assert_eq!(parts[1].tables.iter().map(Table::rows).collect::<Vec<_>>(), [60, 30]);
        let mut one = run(twice());
        one.tables.extend(run(rows(120).collect()).tables);
        assert_eq!(one.recordings().len(), 1);
    }
}
