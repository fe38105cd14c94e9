//! Text with columns: any separator, decimal mark and encoding; lists in cells; clocks of any unit.

mod dialect;
mod layout;
mod text;
mod width;

use std::path::Path;

use csv::ByteRecord;

use crate::clock::{self, ClockUnit};
use crate::error::{LogError, LogPlace};
use crate::table::{Column, Run, Table};
use layout::{CellKind, Layout, is_empty, items, number, number_of};
use text::Text;
use width::{Width, same_names};

/// Names of columns that count rows, and are not a clock.
const COUNTERS: [&str; 9] = ["index", "frame", "sample", "seq", "row", "id", "step", "count", "n"];

pub(crate) fn read(path: &Path, unit: Option<ClockUnit>) -> Result<Run, LogError> {
    let text = Text::open(path)?;
    let Some(layout) = Layout::guess(&text.sample) else {
        let remedy = "write a header with the names of the columns, and a row of numbers for each instant";
        return Err(LogError::other(path, "it is empty", remedy));
    };
    let is_control = |c: char| c.is_control() && c != '\t';
    if layout.header.iter().any(|name| name.contains(is_control)) {
        let remedy = "name a table of numbers, or a log that `feeler import` reads";
        return Err(LogError::other(path, "it is not a text with columns", remedy));
    }
    let clock_at = clock_column(&layout);
    let mut cells = Cells::new(path, &layout, clock_at);
    let mut rows = text.rows(&layout.dialect);
    let mut record = ByteRecord::new();
    let mut number = 0;
    let mut width = Width::default();
    loop {
        number += 1;
        let is_row = rows.next(&mut record).map_err(|error| match error.into_kind() {
            csv::ErrorKind::Io(error) => LogError::open(path)(error),
            other => LogError::damaged(
                path,
                LogPlace::Row(number),
                format!("{other:?}"),
                "write a row of numbers for each instant",
            ),
        })?;
        if !is_row {
            break;
        }
        if number > layout.rows_before {
            width.check(path, number, &layout, &record)?;
            cells.push(&record);
        }
    }
    let mut run = cells.into_run(path, &layout, unit);
    run.notes.extend(width.note(&layout));
    run.notes.extend(same_names(&layout));
    Ok(run)
}

/// The clock's column: by its name, by its calendar times, or the first one if it increases.
fn clock_column(layout: &Layout) -> Option<usize> {
    let usable = |i: &usize| matches!(layout.kinds[*i], CellKind::Number | CellKind::Calendar);
    let named = |i: &usize| clock::named(&layout.header[*i]);
    let all = || (0..layout.header.len()).filter(usable);
    all()
        .find(|i| layout.header[*i] == "t_s")
        .or_else(|| all().find(|i| named(i).is_some_and(|name| name.unit.is_some())))
        .or_else(|| all().find(|i| named(i).is_some()))
        .or_else(|| all().find(|i| layout.kinds[*i] == CellKind::Calendar))
        .or_else(|| {
            let name = layout.header.first()?.to_ascii_lowercase();
            let is_counter = COUNTERS.iter().any(|counter| name.ends_with(counter));
            (layout.kinds.first() == Some(&CellKind::Number) && !is_counter).then_some(0)
        })
}

/// Cells of a table, column by column.
struct Cells<'a> {
    layout: &'a Layout,
    columns: Vec<Vec<Column>>,
    clock: Option<usize>,
    /// The clock as whole numbers, while all its cells are.
    whole: Option<Vec<i64>>,
}

impl<'a> Cells<'a> {
    fn new(path: &Path, layout: &'a Layout, clock: Option<usize>) -> Self {
        let columns = layout.header.iter().zip(&layout.kinds).zip(&layout.units).enumerate();
        let columns = columns.map(|(i, ((name, kind), unit))| {
            let plain = |name: String| Column { unit: unit.clone(), ..Column::new(name, i + 1) };
            match kind {
                CellKind::List(length) => {
                    let names = item_names(path, *length);
                    let item =
                        |k: usize| names.as_ref().map_or_else(|| k.to_string(), |names| names[k].clone());
                    (0..*length).map(|k| plain(format!("{name}[{}]", item(k)))).collect()
                }
                _ => vec![plain(name.clone())],
            }
        });
        Self { layout, columns: columns.collect(), clock, whole: Some(Vec::new()) }
    }

    fn push(&mut self, record: &ByteRecord) {
        let comma = self.layout.dialect.decimal_comma;
        // One check of a whole row takes less time than one of each cell.
        let row = std::str::from_utf8(record.as_slice()).ok();
        for (i, columns) in self.columns.iter_mut().enumerate() {
            let cell = record.get(i).unwrap_or_default().trim_ascii();
            if self.clock == Some(i) {
                let text = std::str::from_utf8(cell).unwrap_or_default();
                let is_calendar = self.layout.kinds[i] == CellKind::Calendar;
                let time = if is_calendar { clock::calendar_ns(text) } else { text.parse().ok() };
                push_whole(&mut self.whole, time);
                if is_calendar {
                    columns[0].values.push(time.map_or(f64::NAN, |ns| ns as f64));
                    continue;
                }
            }
            if let CellKind::List(_) = self.layout.kinds[i] {
                push_list(columns, cell);
            } else if let Some(value) = row
                .and_then(|row| row.get(record.range(i)?))
                .map_or_else(|| number(cell, comma), |text| number_of(text.trim_ascii(), comma))
            {
                columns[0].values.push(value);
            } else if is_empty(cell) {
                columns[0].values.push(f64::NAN);
            } else {
                columns[0].push_bad();
            }
        }
    }

    fn into_run(self, path: &Path, layout: &Layout, unit: Option<ClockUnit>) -> Run {
        let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let mut columns = self.columns;
        let rows = columns.iter().flatten().next().map_or(0, |column| column.values.len());
        let mut clock = None;
        let mut times_s = Vec::new();
        if let Some(i) = self.clock {
            let name = &layout.header[i];
            let stated = clock::named(name).and_then(|name| name.unit).or_else(|| {
                let written = layout.units[i].as_deref()?.trim_matches(['[', ']', '(', ')']);
                ClockUnit::named(written)
            });
            let is_calendar = layout.kinds[i] == CellKind::Calendar;
            let stated = if is_calendar { Some(ClockUnit::Nanoseconds) } else { unit.or(stated) };
            let whole = self.whole.filter(|whole| whole.len() == rows && rows > 0);
            let (mut found, times) = match whole {
                Some(whole) => clock::make_whole(name, &whole, stated),
                None => clock::make(name, &columns[i][0].values, stated),
            };
            if is_calendar {
                found.why = "its cells are calendar times".into();
            }
            let advances = times.windows(2).filter(|pair| pair[1] > pair[0]).count();
            // A first column with another name is a clock only if it advances like one.
            if clock::named(name).is_some()
                || is_calendar
                || 10 * advances >= 9 * rows.saturating_sub(1) && rows > 1
            {
                (clock, times_s) = (Some(found), times);
                columns.remove(i);
            }
        }
        let columns: Vec<Column> = columns.into_iter().flatten().collect();
        let table = Table {
            name: stem.clone(),
            file: path.to_owned(),
            clock,
            times_s,
            rows_before: layout.rows_before,
            columns,
        };
        Run { name: stem, tables: vec![table], notes: Vec::new() }
    }
}

/// One time that is not a whole number ends them.
fn push_whole(whole: &mut Option<Vec<i64>>, time: Option<i64>) {
    match (whole.as_mut(), time) {
        (Some(values), Some(time)) => values.push(time),
        _ => *whole = None,
    }
}

fn push_list(columns: &mut [Column], cell: &[u8]) {
    let Some(mut items) = items(cell) else {
        for column in columns {
            if is_empty(cell) {
                column.values.push(f64::NAN);
            } else {
                column.push_bad();
            }
        }
        return;
    };
    for column in columns {
        match items.next() {
            None => column.values.push(f64::NAN),
            Some(item) => match number(item, false) {
                Some(value) => column.values.push(value),
                None if is_empty(item) => column.values.push(f64::NAN),
                None => column.push_bad(),
            },
        }
    }
}

/// Names of the items of a list: the lines of a text file beside the table, if their number matches.
fn item_names(path: &Path, length: usize) -> Option<Vec<String>> {
    let mut texts: Vec<_> =
        path.parent()?.read_dir().ok()?.filter_map(Result::ok).map(|entry| entry.path()).collect();
    texts.retain(|file| file.extension().is_some_and(|ending| ending == "txt"));
    texts.sort();
    texts.iter().find_map(|file| {
        let text = std::fs::read_to_string(file).ok().filter(|text| text.len() < 1 << 14)?;
        let names: Vec<String> =
            text.lines().map(|line| line.trim().to_owned()).filter(|l| !l.is_empty()).collect();
        let is_name = |name: &String| {
            name.starts_with(|c: char| c.is_alphabetic() || c == '_') && !name.contains(char::is_whitespace)
        };
        (names.len() == length && names.iter().all(is_name)).then_some(names)
    })
}
