//! The layout of a table, from its first rows: its dialect, its header, what its cells hold.

use csv::ByteRecord;

use super::dialect::{Dialect, Separator};
use super::text::Rows;
use crate::clock::calendar_ns;

/// Number of rows from which the layout of a table is guessed.
const SAMPLE_ROWS: usize = 200;

/// The layout of the first rows of a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) dialect: Dialect,
    /// Names of the columns; numbers without a header.
    pub(super) header: Vec<String>,
    /// Units of the columns, if a row below the header states them.
    pub(super) units: Vec<Option<String>>,
    /// Rows before the first one with data, without comments.
    pub(super) rows_before: usize,
    pub(super) kinds: Vec<CellKind>,
}

/// The kind of a column's cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CellKind {
    Number,
    /// A list in brackets, and its length.
    List(usize),
    /// A calendar time.
    Calendar,
    Text,
}

/// Whether a cell is empty, in one of the usual ways.
pub(super) fn is_empty(cell: &[u8]) -> bool {
    matches!(cell, b"" | b"-" | b"NaN" | b"nan" | b"NAN" | b"NA" | b"N/A" | b"null" | b"None" | b"NULL")
}

/// A number as it is written.
pub(super) fn number(cell: &[u8], decimal_comma: bool) -> Option<f64> {
    number_of(std::str::from_utf8(cell).ok()?, decimal_comma)
}

/// The same of a text.
pub(super) fn number_of(text: &str, decimal_comma: bool) -> Option<f64> {
    if decimal_comma && text.contains(',') {
        return text.replacen(',', ".", 1).parse().ok();
    }
    text.parse().ok().or_else(|| match text.to_ascii_lowercase().as_str() {
        "true" => Some(1.0),
        "false" => Some(0.0),
        _ => None,
    })
}

/// Items of a list in brackets.
pub(super) fn items(cell: &[u8]) -> Option<impl Iterator<Item = &[u8]>> {
    let inner = cell.strip_prefix(b"[")?.strip_suffix(b"]")?;
    let mark = if inner.contains(&b',') { b',' } else { b' ' };
    Some(inner.split(move |b| *b == mark).map(<[u8]>::trim_ascii).filter(|item| !item.is_empty()))
}

impl Layout {
    /// Guesses from the first lines of a text; `None` if there are none.
    pub(super) fn guess(sample: &[u8]) -> Option<Self> {
        // The last line may be incomplete.
        let end = sample.iter().rposition(|b| *b == b'\n').map_or(sample.len(), |at| at + 1);
        let sample = &sample[..end];
        let comment = if sample.trim_ascii_start().starts_with(b"%") { b'%' } else { b'#' };
        let marks = [b',', b';', b'\t', b'|'].map(Separator::Mark);
        let (_, dialect, rows) = marks
            .into_iter()
            .chain([Separator::Blanks])
            .filter_map(|separator| scored(sample, separator, comment))
            .rev()
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Self::of(dialect, &rows, sample))
    }

    fn of(dialect: Dialect, rows: &[ByteRecord], sample: &[u8]) -> Self {
        let comma = dialect.decimal_comma;
        let shows_data = |row: &ByteRecord| row.iter().any(|cell| is_data(cell.trim_ascii(), comma));
        let is_header = |row: &ByteRecord| {
            row.iter().any(|cell| !is_empty(cell.trim_ascii()) && !is_data(cell.trim_ascii(), comma))
        };
        let first = &rows[0];
        let has_data_after = rows.len() < 2 || rows[1..].iter().any(shows_data);
        let mut rows_before = usize::from(is_header(first) && !shows_data(first) && has_data_after);
        // A header may have names that are numbers beside others that are not, as in `t, 1, 2`.
        if rows_before == 0 && is_header(first) && rows.len() > 1 && !is_header(&rows[1]) {
            rows_before = 1;
        }
        let mut units = Vec::new();
        let width = rows.iter().map(ByteRecord::len).max().unwrap_or(0);
        let header = if rows_before > 0 {
            let states_units =
                rows.len() > 2 && !shows_data(&rows[1]) && !is_blank(&rows[1]) && shows_data(&rows[2]);
            if states_units {
                rows_before = 2;
                units = texts(&rows[1]).map(|text| Some(text).filter(|text| !text.is_empty())).collect();
            }
            texts(first).collect()
        } else {
            header_in_remark(sample, &dialect, first.len())
                .unwrap_or_else(|| (1..=width).map(|number| number.to_string()).collect::<Vec<String>>())
        };
        units.resize(header.len(), None);
        let data = &rows[rows_before.min(rows.len())..];
        let kinds = (0..header.len()).map(|i| kind(data, i, comma)).collect();
        Self { dialect, header, units, rows_before, kinds }
    }
}

fn texts(row: &ByteRecord) -> impl Iterator<Item = String> {
    row.iter().map(|cell| String::from_utf8_lossy(cell.trim_ascii()).into_owned())
}

fn is_blank(row: &ByteRecord) -> bool {
    row.iter().all(|cell| cell.trim_ascii().is_empty())
}

fn is_data(cell: &[u8], decimal_comma: bool) -> bool {
    number(cell, decimal_comma).is_some()
        || items(cell).is_some()
        || std::str::from_utf8(cell).is_ok_and(|text| calendar_ns(text).is_some())
}

/// Splits the sample by a separator. The score is the share of rows with the usual width times the share of
/// cells with data in them. It is almost zero for a single column.
fn scored(sample: &[u8], separator: Separator, comment: u8) -> Option<(f64, Dialect, Vec<ByteRecord>)> {
    let mut dialect = Dialect { separator, comment, decimal_comma: false };
    let mut reader = Rows::of(Box::new(std::io::Cursor::new(sample.to_vec())), &dialect);
    let mut rows = Vec::new();
    let mut record = ByteRecord::new();
    while rows.len() < SAMPLE_ROWS && reader.next(&mut record).ok()? {
        rows.push(record.clone());
    }
    let mut widths: Vec<usize> = rows.iter().map(ByteRecord::len).collect();
    widths.sort_unstable();
    let usual = *widths.get(widths.len() / 2)?;
    let regular = widths.iter().filter(|width| **width == usual).count() as f64 / widths.len() as f64;
    let cells = || rows.iter().skip(1).flat_map(ByteRecord::iter).map(<[u8]>::trim_ascii);
    let share = |comma: bool| {
        let count = cells().filter(|cell| is_data(cell, comma) || is_empty(cell)).count();
        (count as f64 + 0.1) / (cells().count() as f64 + 0.1)
    };
    // Between commas a number with a comma is in quotes. There `"1,234"` may be thousands.
    let is_decimal = |cell: &[u8]| {
        let is_sure = separator != Separator::Mark(b',') || !may_be_thousands(cell);
        cell.contains(&b',') && is_sure && number(cell, true).is_some()
    };
    dialect.decimal_comma = cells().any(is_decimal) && share(true) > share(false);
    // Rows of one cell are the last resort.
    let width = if usual > 1 { 1.0 } else { 1e-3 };
    Some((width * regular * share(dialect.decimal_comma), dialect, rows))
}

/// Whether the only comma of a number may separate its thousands.
fn may_be_thousands(cell: &[u8]) -> bool {
    let mut parts = cell.strip_prefix(b"-").unwrap_or(cell).split(|b| *b == b',');
    let (Some(before), Some(after), None) = (parts.next(), parts.next(), parts.next()) else { return false };
    (1..=3).contains(&before.len())
        && before[0] != b'0'
        && after.len() == 3
        && after.iter().all(u8::is_ascii_digit)
}

fn kind(data: &[ByteRecord], i: usize, decimal_comma: bool) -> CellKind {
    let cells =
        || data.iter().filter_map(|row| row.get(i)).map(<[u8]>::trim_ascii).filter(|cell| !is_empty(cell));
    if cells().next().is_none() || cells().any(|cell| number(cell, decimal_comma).is_some()) {
        return CellKind::Number;
    }
    if let Some(longest) = cells().filter_map(items).map(Iterator::count).max() {
        return CellKind::List(longest);
    }
    let is_calendar = |cell: &[u8]| std::str::from_utf8(cell).is_ok_and(|text| calendar_ns(text).is_some());
    if cells().any(is_calendar) { CellKind::Calendar } else { CellKind::Text }
}

/// The header of a table without one, if the last comment above it has as many names as columns.
fn header_in_remark(sample: &[u8], dialect: &Dialect, width: usize) -> Option<Vec<String>> {
    let lines = sample.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
    let remark = lines.take_while(|line| line.first() == Some(&dialect.comment)).last()?;
    let remark = &remark[1..];
    let mut rows = Rows::of(Box::new(std::io::Cursor::new(remark.to_vec())), dialect);
    let mut record = ByteRecord::new();
    rows.next(&mut record).ok()?;
    (record.len() == width).then(|| texts(&record).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> Layout {
        Layout::guess(text.as_bytes()).expect("rows")
    }

    #[test]
    fn truth_separators_and_decimal_marks_are_told_apart() {
        for (text, separator, comma) in [
            ("t,x\n0.0,1.5\n0.1,1.6\n", Separator::Mark(b','), false),
            ("t;x\n0,0;1,5\n0,1;1,6\n", Separator::Mark(b';'), true),
            ("t;x\n0.0;1.5\n0.1;1.6\n", Separator::Mark(b';'), false),
            ("t\tx\n0,0\t1,5\n0,1\t1,6\n", Separator::Mark(b'\t'), true),
            ("t|x\n0.0|1.5\n0.1|1.6\n", Separator::Mark(b'|'), false),
            ("  t    x\n 0.0  1.5\n 0.1  1.6\n", Separator::Blanks, false),
            ("t,q\n0,\"[1.0, 2.0]\"\n1,\"[1.5, 2.5]\"\n", Separator::Mark(b','), false),
            ("x\n1\n2\n3\n", Separator::Mark(b','), false),
            ("\"t\";\"x\"\n\"0,0\";\"1,5\"\n\"0,1\";\"1,6\"\n", Separator::Mark(b';'), true),
            ("\"t\",\"x\"\n\"0,0\",\"1,5\"\n\"0,1\",\"1,6\"\n", Separator::Mark(b','), true),
            ("t,x\n0,\"-1,500\"\n1,\"0,125\"\n2,\"1,625\"\n", Separator::Mark(b','), true),
            ("t,x\n0,\"1,500\"\n1,\"12,125\"\n", Separator::Mark(b','), false),
        ] {
            let found = layout(text).dialect;
            assert_eq!((found.separator, found.decimal_comma), (separator, comma), "{text:?}");
        }
    }

    #[test]
    fn truth_headers_units_and_kinds_are_found() {
        let found = layout("t,x,what\ns,mm,\n0,1,a\n1,2,b\n");
        assert_eq!(found.header, ["t", "x", "what"]);
        assert_eq!(found.units, [Some("s".into()), Some("mm".into()), None]);
        assert_eq!(found.rows_before, 2);
        assert_eq!(found.kinds, [CellKind::Number, CellKind::Number, CellKind::Text]);
        let found = layout("0.0 1\n0.1 2\n");
        assert_eq!((found.header, found.rows_before), (vec!["1".to_owned(), "2".into()], 0));
        let found = layout("# made by numpy\n# t q\n0.0 1\n0.1 2\n");
        assert_eq!((found.header, found.rows_before), (vec!["t".to_owned(), "q".into()], 0));
        let found = layout("time,q\n2024-05-01T00:00:00,\"[1,2,3]\"\n2024-05-01T00:00:01,\"[1,2,3]\"\n");
        assert_eq!(found.kinds, [CellKind::Calendar, CellKind::List(3)]);
    }
}
