//! Columns of several tables on common instants.

use std::ops::Range;
use std::path::Path;

use feeler_problem::short;

use crate::clock::median_step;
use crate::error::LogError;
use crate::table::{Column, Run, Table};

/// Largest share of empty cells that are taken for losses of the recorder.
const MOST_LOST: f64 = 0.05;
/// Most readings for each stretch of empty cells, in a column with rows of its own. One long stretch of empty
/// cells is a loss.
const MOST_READINGS: usize = 4;
/// Most empty cells in a row between readings of a column that has more than half of the rows.
const MOST_TOGETHER: usize = 20;

/// A column that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick<'a> {
    /// Its name, its full name with that of its table, or its number in the file.
    pub name: &'a str,
    /// Whether it holds its value between readings, as a command does.
    pub is_held: bool,
}

/// Columns on common instants.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Column of the clock.
    pub clock: String,
    /// The instants, s.
    pub times_s: Vec<f64>,
    /// For each pick, its values; NaN if unknown.
    pub values: Vec<Vec<f64>>,
    /// For each pick, the instants that no reading of it is nearest to; empty if there are none, or if the
    /// pick is held.
    pub bridged: Vec<Vec<bool>>,
    /// For each pick, the index of the first invalid cell, and the number of invalid cells.
    pub bad: Vec<Option<(usize, usize)>>,
    /// Rows of the file before the first one with data.
    pub rows_before: usize,
    /// Columns that were resampled, a sentence each.
    pub notes: Vec<String>,
}

impl Series {
    /// Leaves out rows that repeat the one before, time and all, as a recorder writes them that asks more
    /// often than values change. Returns how many.
    pub fn leave_out_repeats(&mut self) -> usize {
        let same = |a: f64, b: f64| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
        let is_repeat = |row: usize| {
            row > 0
                && same(self.times_s[row], self.times_s[row - 1])
                && self.values.iter().all(|values| same(values[row], values[row - 1]))
        };
        let kept: Vec<usize> = (0..self.times_s.len()).filter(|row| !is_repeat(*row)).collect();
        let left_out = self.times_s.len() - kept.len();
        if left_out > 0 {
            self.times_s = kept.iter().map(|row| self.times_s[*row]).collect();
            for values in &mut self.values {
                *values = kept.iter().map(|row| values[*row]).collect();
            }
            for bridged in self.bridged.iter_mut().filter(|bridged| !bridged.is_empty()) {
                *bridged = kept.iter().map(|row| bridged[*row]).collect();
            }
        }
        left_out
    }

    /// Its rows in parts that begin at these indices, from the first row on. The first part has the notes.
    #[must_use]
    pub fn parts(self, starts: &[usize]) -> Vec<Self> {
        if starts.len() < 2 {
            return vec![self];
        }
        let ends = starts.iter().skip(1).copied().chain([self.times_s.len()]);
        let mut parts: Vec<Self> =
            starts.iter().zip(ends).map(|(&start, end)| self.part(start..end)).collect();
        parts.iter_mut().skip(1).for_each(|part| part.notes.clear());
        parts
    }

    fn part(&self, rows: Range<usize>) -> Self {
        let bad = |bad: &Option<(usize, usize)>| {
            bad.filter(|(first, _)| rows.contains(first)).map(|(first, cells)| (first - rows.start, cells))
        };
        Self {
            clock: self.clock.clone(),
            times_s: self.times_s[rows.clone()].to_vec(),
            values: self.values.iter().map(|values| values[rows.clone()].to_vec()).collect(),
            bridged: (self.bridged.iter())
                .map(|bridged| bridged.get(rows.clone()).unwrap_or_default().to_vec())
                .collect(),
            bad: self.bad.iter().map(bad).collect(),
            rows_before: self.rows_before + rows.start,
            notes: self.notes.clone(),
        }
    }
}

impl Run {
    /// The table and column of a name: a column's own name, its full name, a list with the number of an item,
    /// or its number in the file. Slashes of topics may be omitted or replaced by dots.
    pub fn find(&self, name: &str) -> Option<(&Table, &Column)> {
        let all =
            || self.tables.iter().flat_map(|table| table.columns.iter().map(move |column| (table, column)));
        let plain = |text: &str| text.trim_start_matches('/').replace('/', ".");
        let wanted = plain(name);
        all()
            .find(|(table, column)| column.name == name || table.full_name(column) == name)
            .or_else(|| all().find(|(table, column)| plain(&table.full_name(column)) == wanted))
            .or_else(|| {
                let shorter = wanted.strip_suffix(".data").or_else(|| wanted.strip_suffix(".value"))?;
                all().find(|(table, column)| plain(&table.full_name(column)) == shorter)
            })
            .or_else(|| {
                // An item of a list whose items have names: `action[2]` counts from zero.
                let (list, item) = wanted.strip_suffix(']')?.rsplit_once('[')?;
                let number: usize = item.parse().ok()?;
                let is_item = |text: &str| {
                    let rest = text.strip_prefix(list).filter(|rest| rest.starts_with('['));
                    rest.is_some_and(|rest| rest.find(']') == Some(rest.len() - 1))
                };
                self.tables.iter().find_map(|table| {
                    let is_its = |column: &Column| {
                        is_item(&plain(&column.name)) || is_item(&plain(&table.full_name(column)))
                    };
                    let mut items = table.columns.iter().filter(|column| is_its(column));
                    Some((table, items.nth(number)?))
                })
            })
            .or_else(|| {
                let number: usize = name.parse().ok()?;
                all().find(|(_, column)| column.number == number)
            })
    }

    /// The name of every column; the full name if there are several tables.
    pub fn names(&self) -> Vec<String> {
        let is_alone = self.tables.len() == 1;
        let name = |table: &Table, column: &Column| {
            let has_own = is_alone && !column.name.is_empty();
            if has_own { column.name.clone() } else { table.full_name(column) }
        };
        self.tables
            .iter()
            .flat_map(|table| table.columns.iter().map(move |column| name(table, column)))
            .collect()
    }
}

/// Brings columns to common instants: those of the requested column with the most values, or all rows of its
/// table if it has lost some. Others are interpolated, or held. A single table stays unchanged if no column
/// has rows of its own.
///
/// # Errors
/// A column that the run does not have, and a table without a clock if one is needed.
pub fn on_one_grid(file: &Path, run: &Run, picks: &[Pick<'_>]) -> Result<Series, LogError> {
    let found = picks.iter().map(|pick| {
        run.find(pick.name).ok_or_else(|| LogError::NoColumn {
            file: file.to_owned(),
            name: pick.name.into(),
            remedy: format!("`feeler import {}` lists its columns", file.display()),
        })
    });
    let found: Vec<(&Table, &Column)> = found.collect::<Result<_, _>>()?;
    let densest =
        found.iter().max_by_key(|(table, column)| (column.present(), std::cmp::Reverse(table.columns.len())));
    let Some((base, leader)) =
        densest.copied().or_else(|| run.tables.first().map(|table| (table, &table.columns[0])))
    else {
        return Err(LogError::other(
            file,
            "it holds no column of numbers",
            "`feeler import` lists what it holds",
        ));
    };
    let is_one_table = found.iter().all(|(table, _)| std::ptr::eq(*table, base));
    let Some(clock) = &base.clock else {
        return Err(LogError::other(
            file,
            "no column of it is a clock",
            "name one `t_s`, or state the rate of its rows: `rate = \"1 kHz\"` in dataset.toml, \
             `feeler import --rate 1000`",
        ));
    };
    let bad = |column: &Column| column.bad.as_ref().map(|bad| (bad.first, bad.count));
    if is_one_table && !found.iter().any(|(_, column)| has_own_rows(column)) {
        return Ok(Series {
            clock: clock.column.clone(),
            times_s: base.times_s.clone(),
            values: found.iter().map(|(_, column)| column.values.clone()).collect(),
            bridged: vec![Vec::new(); found.len()],
            bad: found.iter().map(|(_, column)| bad(column)).collect(),
            rows_before: base.rows_before,
            notes: Vec::new(),
        });
    }
    let times_s = instants(base, leader);
    let (mut values, mut bridged, mut notes) = (Vec::new(), Vec::new(), Vec::new());
    for (pick, (table, column)) in picks.iter().zip(&found) {
        let Some(other) = &table.clock else {
            return Err(LogError::other(
                file,
                format!("`{}` has no clock", table.full_name(column)),
                "give its file a column `t_s`; in an npz, an array of times as long as this one",
            ));
        };
        let shift_s = other.origin_s - clock.origin_s;
        let readings = table.times_s.iter().zip(&column.values).filter(|(_, x)| !x.is_nan());
        let (at, given): (Vec<f64>, Vec<f64>) = readings.map(|(t, x)| (t + shift_s, *x)).unzip();
        apart(file, base, &times_s, table, &at)?;
        let between = if pick.is_held { Vec::new() } else { bridged_of(&at, &times_s) };
        let is_broken = std::ptr::eq(*table, base) && at.len() < times_s.len();
        if at.len() < 2 * times_s.len() / 3 || is_broken {
            let rate =
                table.rate_of_hz(column).map_or_else(String::new, |rate| format!(" at {} Hz", short(rate)));
            let unknown = between.iter().filter(|is_bridged| **is_bridged).count();
            let how = if pick.is_held {
                "held between them".to_owned()
            } else {
                format!("interpolated between them: {unknown} rows bridged, counted as unknown")
            };
            notes.push(format!("`{}` has {} readings{rate}, and is {how}", pick.name, at.len()));
        }
        values.push(sampled(&at, &given, &times_s, pick.is_held));
        bridged.push(between);
    }
    let bad = found.iter().map(|(_, column)| bad(column)).collect();
    let (clock, rows_before) = (clock.column.clone(), base.rows_before);
    Ok(Series { clock, times_s, values, bridged, bad, rows_before, notes })
}

/// The error of two tables that share no time: their clocks have other origins.
fn apart(file: &Path, base: &Table, base_s: &[f64], table: &Table, table_s: &[f64]) -> Result<(), LogError> {
    let ends = |times: &[f64]| Some((*times.first()?, *times.last()?));
    let (Some(own), Some(other)) = (ends(base_s), ends(table_s)) else { return Ok(()) };
    if other.0 <= own.1 && own.0 <= other.1 {
        return Ok(());
    }
    let what = format!(
        "`{}` is of {} to {} s and `{}` of {} to {} s on its clock: they share no time",
        base.name,
        short(own.0),
        short(own.1),
        table.name,
        short(other.0),
        short(other.1)
    );
    Err(LogError::other(file, what, "bring both clocks to one origin, or name files of one run"))
}

/// Whether the empty cells of a column are rows of other columns: they are more than a recorder loses, and
/// spread. A single long stretch is a loss.
fn has_own_rows(column: &Column) -> bool {
    let rows = column.values.len();
    let empty = rows - column.present();
    if column.bad.is_some() || empty as f64 <= MOST_LOST * rows as f64 {
        return false;
    }
    let stretches = column.values.chunk_by(|a, b| a.is_nan() == b.is_nan());
    let lengths: Vec<usize> = stretches.filter(|cells| cells[0].is_nan()).map(<[f64]>::len).collect();
    let are_spread = MOST_READINGS * lengths.len() >= column.present();
    2 * empty >= rows && are_spread || lengths.iter().max().is_none_or(|longest| *longest <= MOST_TOGETHER)
}

/// The instants of a column's readings; those of all rows of its table if these are more even, since then the
/// column has lost readings.
fn instants(table: &Table, column: &Column) -> Vec<f64> {
    let readings = table.times_s.iter().zip(&column.values).filter(|(_, x)| !x.is_nan());
    let own: Vec<f64> = readings.map(|(t, _)| *t).collect();
    let is_whole = own.len() == table.times_s.len();
    if is_whole || odd_steps(&own) <= odd_steps(&table.times_s) { own } else { table.times_s.clone() }
}

/// Number of steps that differ from the usual one by more than half of it.
fn odd_steps(times: &[f64]) -> usize {
    let Some(usual) = median_step(times) else { return 0 };
    times.windows(2).filter(|pair| ((pair[1] - pair[0]) / usual - 1.0).abs() > 0.5).count()
}

/// The instants that are the nearest to none of the readings `at`; empty if there are none.
fn bridged_of(at: &[f64], times: &[f64]) -> Vec<bool> {
    let mut is_bridged = vec![true; times.len()];
    let mut next = 0;
    for t in at {
        while next + 1 < times.len() && (times[next + 1] - t).abs() <= (times[next] - t).abs() {
            next += 1;
        }
        is_bridged[next] = false;
    }
    if is_bridged.contains(&true) { is_bridged } else { Vec::new() }
}

/// A series at other instants: held, or linear between its neighbours. Outside it keeps its end values.
fn sampled(at: &[f64], values: &[f64], times: &[f64], is_held: bool) -> Vec<f64> {
    let mut next = 0;
    let value = |t: &f64| {
        // Instants of one clock may differ by rounding.
        while next < at.len() && at[next] <= *t {
            next += 1;
        }
        let Some(i) = next.checked_sub(1) else { return values.first().copied().unwrap_or(f64::NAN) };
        if is_held || next == at.len() {
            return values[i];
        }
        let share = (t - at[i]) / (at[next] - at[i]);
        values[i] + share * (values[next] - values[i])
    };
    times.iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(times_s: Vec<f64>, values: Vec<f64>) -> Table {
        Table {
            name: String::new(),
            file: "a.csv".into(),
            clock: None,
            times_s,
            rows_before: 1,
            columns: vec![Column { values, ..Column::default() }],
        }
    }

    /// A column on every other row has a rate of its own. One without every fifth reading has lost them.
    #[test]
    fn truth_instants_are_those_of_readings_unless_the_rows_are_more_even() {
        let times: Vec<f64> = (0..100).map(f64::from).collect();
        let without = |is_empty: fn(usize) -> bool| {
            let values = (0..100).map(|k| if is_empty(k) { f64::NAN } else { 1.0 }).collect();
            let table = table(times.clone(), values);
            (has_own_rows(&table.columns[0]), instants(&table, &table.columns[0]).len())
        };
        assert_eq!(without(|k| k % 2 == 1), (true, 50));
        assert_eq!(without(|k| k % 5 == 3), (true, 100));
        // Few are lost here and there, and many in one stretch.
        assert_eq!(without(|k| k % 25 == 3), (false, 100));
        assert_eq!(without(|k| (30..60).contains(&k)), (false, 100));
        // Most are lost in one stretch; a slow column that begins late has rows of its own.
        assert!(!without(|k| (10..98).contains(&k)).0);
        assert!(without(|k| k < 30 || k % 4 > 0).0);
    }

    #[test]
    fn truth_between_readings_values_are_on_a_line_or_held() {
        let (at, values) = ([1.0, 2.0, 4.0], [10.0, 20.0, 0.0]);
        let times = [0.0, 1.0, 1.5, 3.0, 4.0, 9.0];
        assert_eq!(sampled(&at, &values, &times, false), [10.0, 10.0, 15.0, 10.0, 0.0, 0.0]);
        assert_eq!(sampled(&at, &values, &times, true), [10.0, 10.0, 10.0, 20.0, 0.0, 0.0]);
    }

    /// Rows 1 and 4 repeat those before them. Row 2 has the time of row 1 and another value.
    #[test]
    fn truth_only_rows_that_repeat_time_and_values_are_left_out() {
        let mut series = Series {
            clock: "t".into(),
            times_s: vec![0.0, 0.0, 0.0, 1.0, 1.0],
            values: vec![vec![1.0, 1.0, 2.0, f64::NAN, f64::NAN], vec![0.0; 5]],
            bridged: vec![Vec::new(), vec![false, false, false, true, true]],
            bad: vec![None; 2],
            rows_before: 1,
            notes: Vec::new(),
        };
        assert_eq!(series.leave_out_repeats(), 2);
        assert_eq!(series.times_s, [0.0, 0.0, 1.0]);
        assert_eq!(series.values[0][..2], [1.0, 2.0]);
        assert_eq!(series.bridged, [vec![], vec![false, false, true]]);
    }

    #[test]
    fn truth_parts_of_a_series_are_its_rows() {
        let whole = Series {
            clock: "t".into(),
            times_s: vec![0.0, 1.0, 7.0, 8.0, 9.0],
            values: vec![vec![1.0, 2.0, 3.0, 4.0, 5.0]],
            bridged: vec![vec![false, false, false, true, false]],
            bad: vec![Some((3, 1))],
            rows_before: 1,
            notes: vec!["said once".into()],
        };
        assert_eq!(whole.clone().parts(&[0]), std::slice::from_ref(&whole));
        let parts = whole.parts(&[0, 2]);
        assert_eq!(parts[0].times_s, [0.0, 1.0]);
        assert_eq!((parts[0].rows_before, &parts[0].bad, parts[0].notes.len()), (1, &vec![None], 1));
        assert_eq!(
            (&parts[1].times_s[..], &parts[1].values[0][..]),
            (&[7.0, 8.0, 9.0][..], &[3.0, 4.0, 5.0][..])
        );
        assert_eq!((parts[1].rows_before, &parts[1].bad, parts[1].notes.len()), (3, &vec![Some((1, 1))], 0));
        assert_eq!(parts[1].bridged, [vec![false, true, false]]);
    }

    /// Each reading is that of one instant at most, and every other instant is unknown.
    #[test]
    fn truth_instants_between_readings_are_bridged() {
        let times = [0.0, 1.0, 2.0, 3.0, 4.0];
        assert_eq!(bridged_of(&[0.1, 2.2, 3.9], &times), [false, true, false, true, false]);
        assert!(bridged_of(&[0.2, 0.9, 2.1, 3.0, 4.3], &times).is_empty());
    }
}
