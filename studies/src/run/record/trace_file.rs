//! Traces as files: Parquet and CSV, first column `t_s`, then the signals under their names.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

use feeler_engine::{EngineError, Program, Scenario, Simulation, Trace};
use parquet::basic::{Compression, Encoding, Repetition, Type as PhysicalType};
use parquet::data_type::DoubleType;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::run::error::RunError;

/// The column of time stamps.
const TIME: &str = "t_s";
/// Rows of a row group: 64 MB for eight columns.
const ROWS_PER_GROUP: usize = 1 << 20;

/// Writes a trace as Parquet: doubles, none missing, Snappy. `about` goes into the file's metadata.
///
/// # Errors
/// Errors of the system or of the format's library.
pub fn write_parquet(trace: &Trace, about: &[(&str, String)], path: &Path) -> Result<(), RunError> {
    let file = File::create(path).map_err(RunError::write(path))?;
    parquet(trace, about, file).map_err(RunError::parquet(path))
}

/// The metadata of a trace's file, by key.
///
/// # Errors
/// A file that does not exist, or is not Parquet.
pub fn about_parquet(path: &Path) -> Result<Vec<(String, String)>, RunError> {
    let file = File::open(path).map_err(RunError::write(path))?;
    let reader = SerializedFileReader::new(file).map_err(RunError::parquet(path))?;
    let entries = reader.metadata().file_metadata().key_value_metadata().into_iter().flatten();
    Ok(entries.filter_map(|entry| Some((entry.key.clone(), entry.value.clone()?))).collect())
}

fn parquet(trace: &Trace, about: &[(&str, String)], file: File) -> Result<(), parquet::errors::ParquetError> {
    let names = std::iter::once(TIME).chain(trace.names.iter().map(String::as_str));
    let column = |name| {
        let kind =
            Type::primitive_type_builder(name, PhysicalType::DOUBLE).with_repetition(Repetition::REQUIRED);
        kind.build().map(Arc::new)
    };
    let columns = names.map(column).collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("trace").with_fields(columns).build()?);
    let metadata = about.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone())).collect();
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::PLAIN)
        .set_key_value_metadata(Some(metadata))
        .build();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties))?;
    for first in (0..trace.t_s.len()).step_by(ROWS_PER_GROUP) {
        let rows = first..trace.t_s.len().min(first + ROWS_PER_GROUP);
        let mut group = writer.next_row_group()?;
        for values in std::iter::once(&trace.t_s).chain(&trace.columns) {
            let Some(mut column) = group.next_column()? else { break };
            column.typed::<DoubleType>().write_batch(&values[rows.clone()], None, None)?;
            column.close()?;
        }
        group.close()?;
    }
    writer.close().map(drop)
}

/// The record of a run as a bench writes it: CSV with its recorded signals under these names.
///
/// # Errors
/// A scenario that cannot be run.
pub fn record_csv(scenario: &Scenario, names: &[&str]) -> Result<String, EngineError> {
    let program = Program::new(scenario)?;
    let mut trace = Trace::new(program.record_names());
    Simulation::<f64>::new(vec![program])?.run(&mut trace)?;
    let mut text = format!("{TIME},{}\n", names.join(","));
    for (row, t_s) in trace.t_s.iter().enumerate() {
        let _ = write!(text, "{t_s:.3}");
        for column in &trace.columns {
            let _ = write!(text, ",{:.6}", column[row]);
        }
        text.push('\n');
    }
    Ok(text)
}

/// Writes a trace as CSV: a header, then every number with the fewest digits that give the same double back.
///
/// # Errors
/// Errors of the system or of the format's library.
pub fn write_csv(trace: &Trace, path: &Path) -> Result<(), RunError> {
    let file = File::create(path).map_err(RunError::write(path))?;
    let mut writer = csv::Writer::from_writer(BufWriter::new(file));
    writer
        .write_record(std::iter::once(TIME).chain(trace.names.iter().map(String::as_str)))
        .map_err(RunError::csv(path))?;
    let mut file = writer.into_inner().map_err(|error| RunError::write(path)(error.into_error()))?;
    for (row, t) in trace.t_s.iter().enumerate() {
        // `{:?}` writes small numbers with an exponent, where `{}` would write all their zeros.
        write!(file, "{t:?}").map_err(RunError::write(path))?;
        for column in &trace.columns {
            write!(file, ",{:?}", column[row]).map_err(RunError::write(path))?;
        }
        file.write_all(b"\n").map_err(RunError::write(path))?;
    }
    file.flush().map_err(RunError::write(path))
}
