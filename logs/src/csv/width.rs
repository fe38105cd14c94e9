//! Rows whose cells do not match the header.

use std::path::Path;

use csv::ByteRecord;

use super::layout::{CellKind, Layout};
use crate::error::{LogError, LogPlace};

/// Rows with fewer cells than the header has names.
#[derive(Debug, Default)]
pub(super) struct Width {
    /// The first one, counted from one, and its cells.
    first: Option<(usize, usize)>,
    rows: usize,
}

impl Width {
    /// Counts a row that is too short.
    ///
    /// # Errors
    /// A row with more cells than names: the numbers behind a separator too many belong to other columns. A
    /// quote that is not closed in its row: it takes the rows below into its cell.
    pub(super) fn check(
        &mut self,
        path: &Path,
        row: usize,
        layout: &Layout,
        record: &ByteRecord,
    ) -> Result<(), LogError> {
        let fail = |what: String, remedy| LogError::damaged(path, LogPlace::Row(row), what, remedy);
        let width = layout.header.len();
        let is_text = |i: usize| layout.kinds.get(i) == Some(&CellKind::Text);
        let in_lines = record.as_slice().contains(&b'\n')
            && record.iter().enumerate().any(|(i, cell)| cell.contains(&b'\n') && !is_text(i));
        if in_lines {
            let what = "a quote opens here that is not closed in its row";
            return Err(fail(what.into(), "close the quote, or remove it"));
        }
        if record.iter().skip(width).any(|cell| !cell.trim_ascii().is_empty()) {
            let what = format!("it has {} cells, but there are {width} columns", record.len());
            let remedy = "remove the separator too many, put numbers with decimal commas in quotes, or name \
                          every column in the header";
            return Err(fail(what, remedy));
        }
        if record.len() < width {
            self.first.get_or_insert((row, record.len()));
            self.rows += 1;
        }
        Ok(())
    }

    /// The note on short rows.
    pub(super) fn note(&self, layout: &Layout) -> Option<String> {
        let (row, cells) = self.first?;
        let alike = if self.rows == 1 { String::new() } else { format!(" ({} such rows)", self.rows) };
        let width = layout.header.len();
        Some(format!("row {row} has {cells} of {width} cells{alike}: the others count as empty"))
    }
}

/// A note on the first name that several columns have.
pub(super) fn same_names(layout: &Layout) -> Option<String> {
    let names = &layout.header;
    let twice = names.iter().enumerate().find(|(i, name)| !name.is_empty() && names[..*i].contains(name));
    let (i, name) = twice?;
    Some(format!(
        "two columns are called `{name}`: the first counts; name the other by its number, {}",
        i + 1
    ))
}
