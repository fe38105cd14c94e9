//! Columns of several tables on common instants.

use std::path::Path;

use feeler_problem::short;

use crate::error::LogError;
use crate::table::{Column, Run, Table};

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

impl Run {
    /// The table and column of a name: a column's own name, its full name, or its number in the file. Slashes
    /// of topics may be omitted or replaced by dots.
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

/// Brings columns to common instants: those of the requested column with the most values. Others are
/// interpolated, or held. A run with one requested table stays unchanged.
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
    let is_dense = |column: &Column| 2 * column.present() > column.values.len() || column.bad.is_some();
    let Some(clock) = &base.clock else {
        return Err(LogError::other(
            file,
            "no column of it is a clock",
            "name one `t_s`, or state the rate of its rows: `rate = \"1 kHz\"` in dataset.toml, \
             `feeler import --rate 1000`",
        ));
    };
    let bad = |column: &Column| column.bad.as_ref().map(|bad| (bad.first, bad.count));
    if is_one_table && found.iter().all(|(_, column)| is_dense(column)) {
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
    let own = base.times_s.iter().zip(&leader.values).filter(|(_, x)| !x.is_nan());
    let times_s: Vec<f64> = own.map(|(t, _)| *t).collect();
    let (mut values, mut bridged, mut notes) = (Vec::new(), Vec::new(), Vec::new());
    for (pick, (table, column)) in picks.iter().zip(&found) {
        let Some(other) = &table.clock else {
            return Err(LogError::other(
                file,
                format!("`{}` has no clock", table.full_name(column)),
                "give its file a column `t_s`",
            ));
        };
        let shift_s = other.origin_s - clock.origin_s;
        let readings = table.times_s.iter().zip(&column.values).filter(|(_, x)| !x.is_nan());
        let (at, given): (Vec<f64>, Vec<f64>) = readings.map(|(t, x)| (t + shift_s, *x)).unzip();
        let between = if pick.is_held { Vec::new() } else { bridged_of(&at, &times_s) };
        let is_broken = std::ptr::eq(*table, base) && !between.is_empty();
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

    #[test]
    fn truth_between_readings_values_are_on_a_line_or_held() {
        let (at, values) = ([1.0, 2.0, 4.0], [10.0, 20.0, 0.0]);
        let times = [0.0, 1.0, 1.5, 3.0, 4.0, 9.0];
        assert_eq!(sampled(&at, &values, &times, false), [10.0, 10.0, 15.0, 10.0, 0.0, 0.0]);
        assert_eq!(sampled(&at, &values, &times, true), [10.0, 10.0, 10.0, 20.0, 0.0, 0.0]);
    }

    /// Each reading is that of one instant at most, and every other instant is unknown.
    #[test]
    fn truth_instants_between_readings_are_bridged() {
        let times = [0.0, 1.0, 2.0, 3.0, 4.0];
        assert_eq!(bridged_of(&[0.1, 2.2, 3.9], &times), [false, true, false, true, false]);
        assert!(bridged_of(&[0.2, 0.9, 2.1, 3.0, 4.3], &times).is_empty());
    }
}
