//! Tables for the terminal.

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Table, Width, presets};

/// Smallest width of a terminal at which cells are wrapped.
const LEAST_WIDTH: u16 = 60;
/// Blanks on both sides of a cell.
const PADDING: usize = 2;

/// A table without lines, with right-aligned numbers in the columns `right`. On a terminal it is at most as
/// wide as the terminal.
pub(crate) fn table(header: &[&str], right: &[usize], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let rows: Vec<Vec<String>> = rows.into_iter().collect();
    arranged(header, right, &rows, terminal_width())
}

/// Width of the terminal; `None` if there is no terminal. A reported width of a few characters is ignored.
pub(super) fn terminal_width() -> Option<u16> {
    Table::new().width().filter(|width| *width >= LEAST_WIDTH)
}

/// A table of at most this width, or as wide as its content.
fn arranged(header: &[&str], right: &[usize], rows: &[Vec<String>], width: Option<u16>) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Disabled);
    if !header.is_empty() {
        table.set_header(header.iter().copied());
    }
    for row in rows {
        table.add_row(row);
    }
    if let Some(width) = width {
        table.set_width(width);
        table.set_content_arrangement(ContentArrangement::Dynamic);
        for (column, fixed) in fixed_widths(header, rows, usize::from(width)) {
            if let Some(column) = table.column_mut(column) {
                column.set_constraint(ColumnConstraint::Absolute(Width::Fixed(fixed)));
            }
        }
    }
    for &column in right {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table.to_string().lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

/// Widths that a column needs, with its padding.
struct Needs {
    /// Width for header and cells in one line each.
    lines: usize,
    /// Width for cells in one line and a header that is broken between words.
    cells: usize,
    words: usize,
}

/// Widths of columns of a table that must be wrapped. They keep the cells of all columns but the widest in
/// one line, or else the cells with keys and numbers. Empty if even single words do not fit.
fn fixed_widths(header: &[&str], rows: &[Vec<String>], width: usize) -> Vec<(usize, u16)> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or_default().max(header.len());
    let size = |text: &str| text.chars().count();
    let word = |text: &str| text.split_whitespace().map(size).max().unwrap_or_default();
    let needs_of = |column: usize| {
        let head = header.get(column).copied().unwrap_or_default();
        let cells = || rows.iter().filter_map(move |row| row.get(column)).map(String::as_str);
        // An empty column is one character wide.
        let cell = cells().map(size).max().unwrap_or_default().max(1);
        let words = cells().map(word).max().unwrap_or_default().max(word(head)).max(1);
        let (lines, cells) = (cell.max(size(head)), cell.max(word(head)));
        Needs { lines: lines + PADDING, cells: cells + PADDING, words: words + PADDING }
    };
    let needs: Vec<Needs> = (0..columns).map(needs_of).collect();
    let widest = (0..columns).max_by_key(|&column| needs[column].cells).unwrap_or_default();
    let sum = |of: &dyn Fn(usize) -> usize| (0..columns).map(of).sum::<usize>();
    if sum(&|column| needs[column].lines) <= width || sum(&|column| needs[column].words) > width {
        return Vec::new();
    }
    let all_but_widest = |i: usize| if i == widest { needs[i].words } else { needs[i].cells };
    let is_kept = |i: usize| {
        if sum(&all_but_widest) <= width { i != widest } else { needs[i].cells == needs[i].words }
    };
    let kept = (0..columns).filter(|&i| is_kept(i));
    kept.filter_map(|i| Some((i, u16::try_from(needs[i].cells).ok()?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A table of 110 columns in 80: the text is wrapped, and no key is broken.
    #[test]
    fn truth_a_wide_table_wraps_its_text_and_keeps_its_keys_whole() {
        let key = "springs.transmission.stiffness";
        let text = "the first limit of the gain comes from a mode at which motor and tip move apart";
        let rows = [vec![key.to_owned(), "1200000".to_owned(), text.to_owned()]];
        let header = ["number", "value that it has", "why"];
        let narrow = arranged(&header, &[1], &rows, Some(80));
        assert!(narrow.lines().all(|line| line.chars().count() <= 80), "{narrow}");
        assert!(narrow.contains(key) && narrow.contains("1200000"), "{narrow}");
        let wide = arranged(&header, &[1], &rows, None);
        assert!(wide.contains(text) && wide.lines().count() == 2, "{wide}");
    }
}
