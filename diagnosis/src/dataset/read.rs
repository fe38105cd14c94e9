//! Files into columns of numbers: CSV, Parquet, MCAP, told apart by their ending. What is no number becomes
//! NaN, and the checks say where.

use std::io::Read;
use std::path::Path;

use super::fault::NOT_THERE;
use super::{Table, mcap};
use crate::error::DiagnosisError;

/// Reads a table; `held` names columns that keep their value between readings.
pub(super) fn table(path: &Path, held: &[&str]) -> Result<Table, DiagnosisError> {
    // Devices and pipes have no end to wait for.
    if path.exists() && !path.is_file() {
        let reason = "it is not a regular file".into();
        return Err(DiagnosisError::Unreadable { file: path.to_owned(), reason, remedy: NOT_THERE });
    }
    match path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("parquet") => parquet_table(path),
        Some("mcap") => mcap::table(path, held),
        _ => csv_table(path),
    }
}

fn csv_table(path: &Path) -> Result<Table, DiagnosisError> {
    refuse_no_csv(path)?;
    let fail = |source| DiagnosisError::Read { file: path.to_owned(), source };
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .flexible(true)
        .comment(Some(b'#'))
        .from_path(path)
        .map_err(fail)?;
    let header: Vec<String> = reader.headers().map_err(fail)?.iter().map(str::to_owned).collect();
    let remedy = "write a header with the names of the columns, and a row of numbers for each instant";
    if header.iter().all(String::is_empty) {
        return Err(DiagnosisError::Unreadable {
            file: path.to_owned(),
            reason: "it is empty".into(),
            remedy,
        });
    }
    if header.iter().any(|name| name.contains(|c: char| c.is_control()))
        && !header.iter().any(|name| name.contains('\t'))
    {
        return Err(DiagnosisError::Unreadable {
            file: path.to_owned(),
            reason: "it is no text with columns".into(),
            remedy,
        });
    }
    if let [only] = header.as_slice()
        && let Some(mark) = [';', '\t', '|'].into_iter().find(|mark| only.contains(*mark))
    {
        let reason = format!("its columns are separated by {mark:?}, not by commas");
        let remedy = "write it with commas between columns and points in numbers (a spreadsheet's export has a choice for both)";
        return Err(DiagnosisError::Unreadable { file: path.to_owned(), reason, remedy });
    }
    let mut columns = vec![Vec::new(); header.len()];
    for row in reader.records() {
        let row = row.map_err(fail)?;
        for (i, column) in columns.iter_mut().enumerate() {
            column.push(row.get(i).and_then(|cell| cell.parse().ok()).unwrap_or(f64::NAN));
        }
    }
    Ok(Table { file: path.to_owned(), header, columns })
}

/// Refuses what its first bytes show to be no text in UTF-8.
fn refuse_no_csv(path: &Path) -> Result<(), DiagnosisError> {
    let mut start = [0; 16];
    let read = std::fs::File::open(path).and_then(|mut file| file.read(&mut start)).unwrap_or(0);
    let known: [(&[u8], &str, &'static str); 5] = [
        (b"\xff\xfe", "it is a text in UTF-16", UTF_16),
        (b"\xfe\xff", "it is a text in UTF-16", UTF_16),
        (
            b"SQLite format 3\0",
            "it is a database, as ROS 2 bags are",
            "convert it to MCAP with JSON messages, or to CSV",
        ),
        (b"\x89MCAP0\r\n", "it is an MCAP log under another ending", "give it the ending .mcap"),
        (b"PAR1", "it is a Parquet table under another ending", "give it the ending .parquet"),
    ];
    match known.into_iter().find(|(magic, ..)| start[..read].starts_with(magic)) {
        None => Ok(()),
        Some((_, reason, remedy)) => {
            Err(DiagnosisError::Unreadable { file: path.to_owned(), reason: reason.into(), remedy })
        }
    }
}

/// What to do with a spreadsheet's "Unicode text".
const UTF_16: &str = "save it as CSV in UTF-8, with commas between columns and points in numbers";

fn parquet_table(path: &Path) -> Result<Table, DiagnosisError> {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    let remedy = "the table is damaged, cut off or no Parquet: write it again, or as CSV";
    let fail = |reason: String| DiagnosisError::Unreadable { file: path.to_owned(), reason, remedy };
    let file = std::fs::File::open(path).map_err(|error| DiagnosisError::Unreadable {
        file: path.to_owned(),
        reason: error.to_string(),
        remedy: NOT_THERE,
    })?;
    let reader = SerializedFileReader::new(file).map_err(|error| fail(error.to_string()))?;
    let schema = reader.metadata().file_metadata().schema();
    let header: Vec<String> = schema.get_fields().iter().map(|field| field.name().to_owned()).collect();
    let mut columns = vec![Vec::new(); header.len()];
    for row in reader.get_row_iter(None).map_err(|error| fail(error.to_string()))? {
        let row = row.map_err(|error| fail(error.to_string()))?;
        for (column, (_, field)) in columns.iter_mut().zip(row.get_column_iter()) {
            column.push(match *field {
                Field::Double(x) => x,
                Field::Float(x) => f64::from(x),
                Field::Int(x) => f64::from(x),
                Field::Short(x) => f64::from(x),
                Field::Byte(x) => f64::from(x),
                Field::Long(x) => x as f64,
                Field::UInt(x) => f64::from(x),
                Field::UShort(x) => f64::from(x),
                Field::UByte(x) => f64::from(x),
                Field::ULong(x) => x as f64,
                Field::Bool(x) => f64::from(u8::from(x)),
                _ => f64::NAN,
            });
        }
    }
    Ok(Table { file: path.to_owned(), header, columns })
}
