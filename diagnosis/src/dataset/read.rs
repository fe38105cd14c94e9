//! CSV files into columns of numbers. What is no number becomes NaN, and the checks say where.

use std::path::Path;

use super::Table;
use crate::error::DiagnosisError;

pub(super) fn table(path: &Path) -> Result<Table, DiagnosisError> {
    let fail = |source| DiagnosisError::Read { file: path.to_owned(), source };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).comment(Some(b'#')).from_path(path).map_err(fail)?;
    let header: Vec<String> = reader.headers().map_err(fail)?.iter().map(str::to_owned).collect();
    let mut columns = vec![Vec::new(); header.len()];
    for row in reader.records() {
        let row = row.map_err(fail)?;
        for (i, column) in columns.iter_mut().enumerate() {
            column.push(row.get(i).and_then(|cell| cell.parse().ok()).unwrap_or(f64::NAN));
        }
    }
    Ok(Table { file: path.to_owned(), header, columns })
}
