//! Parquet tables: numbers, and lists of numbers in cells.

use std::fs::File;
use std::path::Path;

use parquet::basic::{Compression, LogicalType, TimeUnit};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use crate::clock::{self, ClockUnit};
use crate::error::{LogError, LogPlace};
use crate::packed;
use crate::pages::Checked;
use crate::table::{Column, Run, Table};

const DAMAGED: &str = "the table is damaged, cut off or not Parquet: write it again, or as CSV";
const AS_ZSTD: &str = "write it again with `compression=\"zstd\"`, as by pyarrow.parquet.write_table";
/// Number of rows that are decoded together.
const BATCH: usize = 1 << 14;
/// Longest list that becomes columns.
const LONGEST_LIST: usize = 256;

pub(crate) fn read(path: &Path, unit: Option<ClockUnit>) -> Result<Run, LogError> {
    let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let file = File::open(path).map_err(LogError::open(path))?;
    let size = file.metadata().map_err(LogError::open(path))?.len();
    let fail = |error: ParquetError| {
        LogError::damaged(path, LogPlace::Byte(size), format!("read from its end: {error}"), DAMAGED)
    };
    let reader = SerializedFileReader::new(file).map_err(fail)?;
    let metadata = reader.metadata();
    let schema = metadata.file_metadata().schema_descr_ptr();
    let mut columns = Vec::new();
    let mut notes = Vec::new();
    let mut clock = None;
    let (most, mut numbers) = (packed::most_bytes(size) / 8, 0);
    for leaf in 0..schema.num_columns() {
        let described = schema.column(leaf);
        let name = described.path().parts()[0].clone();
        let number = columns_before(&schema, leaf);
        if described.max_rep_level() > 1 || !is_number(&described) {
            notes.push(format!("{} is left out: it holds no plain numbers", described.path().string()));
            continue;
        }
        let mut cells = Cells::new(&described, most - numbers);
        for group in 0..reader.num_row_groups() {
            if let Some(other) = other_codec(reader.metadata().row_group(group).column(leaf).compression()) {
                let what = format!("its column `{name}` is compressed by {other}, which is not read");
                return Err(LogError::other(path, what, AS_ZSTD));
            }
            let Some(at) = start_of(reader.metadata().row_group(group).column(leaf)) else {
                let what = format!("column `{name}`: its place or size is negative");
                return Err(LogError::damaged(path, LogPlace::Byte(size), what, DAMAGED));
            };
            let fail = |error: ParquetError| {
                let what = format!("column `{name}`: {error}");
                LogError::damaged(path, LogPlace::Byte(at), what, DAMAGED)
            };
            let group = reader.get_row_group(group).map_err(fail)?;
            let pages = Checked::new(group.get_column_page_reader(leaf).map_err(fail)?, &described);
            cells.take(get_column_reader(described.clone(), Box::new(pages))).map_err(fail)?;
        }
        numbers += cells.values.len() as u64;
        let stated = clock_unit(&described).or_else(|| clock::named(&name).and_then(|name| name.unit));
        let is_clock = clock::named(&name).is_some() || clock_unit(&described).is_some();
        if clock.is_none() && is_clock && described.max_rep_level() == 0 {
            clock = Some(cells.into_clock(&name, unit.or(stated)));
            continue;
        }
        if cells.longest > LONGEST_LIST {
            notes.push(format!("{name} is left out: lists of {} numbers", cells.longest));
            continue;
        }
        columns.extend(cells.into_columns(&name, number));
    }
    if clock.is_none()
        && let Some(first) = columns.first().filter(|column| column.number == 1)
        && first.values.len() > 1
        && first.values.windows(2).all(|pair| pair[1] > pair[0])
        && !["index", "frame_index"].contains(&first.name.as_str())
    {
        clock = Some(clock::make(&first.name, &first.values, unit));
        columns.remove(0);
    }
    let (clock, times_s) = clock.map_or((None, Vec::new()), |(clock, times)| (Some(clock), times));
    let table = Table { name: stem.clone(), file: path.to_owned(), clock, times_s, rows_before: 0, columns };
    Ok(Run { name: stem, tables: vec![table], notes })
}

/// The compression of a column, if it cannot be read.
fn other_codec(compression: Compression) -> Option<&'static str> {
    Some(match compression {
        Compression::BROTLI(_) => "brotli",
        Compression::LZO => "lzo",
        _ => return None,
    })
}

/// The first byte of a chunk; `None` if its place or size is negative, which `parquet` asserts.
fn start_of(chunk: &ColumnChunkMetaData) -> Option<u64> {
    let start = chunk.dictionary_page_offset().unwrap_or_else(|| chunk.data_page_offset());
    u64::try_from(start).ok().filter(|_| chunk.compressed_size() >= 0)
}

/// Position of a leaf's own column among those of the table, from one.
fn columns_before(schema: &parquet::schema::types::SchemaDescriptor, leaf: usize) -> usize {
    schema.get_column_root_idx(leaf) + 1
}

fn is_number(described: &ColumnDescriptor) -> bool {
    use parquet::basic::Type;
    matches!(
        described.physical_type(),
        Type::BOOLEAN | Type::INT32 | Type::INT64 | Type::FLOAT | Type::DOUBLE
    )
}

fn clock_unit(described: &ColumnDescriptor) -> Option<ClockUnit> {
    let LogicalType::Timestamp(stamp) = described.logical_type_ref()? else { return None };
    Some(match stamp.unit {
        TimeUnit::MILLIS => ClockUnit::Milliseconds,
        TimeUnit::MICROS => ClockUnit::Microseconds,
        TimeUnit::NANOS => ClockUnit::Nanoseconds,
    })
}

/// Cells of one column; each holds a list if the column is repeated.
struct Cells {
    /// Definition level of a present value.
    full: i16,
    is_list: bool,
    is_unsigned: bool,
    values: Vec<f64>,
    /// Whole numbers, for a clock.
    whole: Vec<i64>,
    /// Start of each row among the values; for lists only.
    starts: Vec<usize>,
    longest: usize,
    /// Values that it may have: a few bytes may stand for any number of equal ones.
    most: u64,
}

impl Cells {
    fn new(described: &ColumnDescriptor, most: u64) -> Self {
        let is_unsigned =
            matches!(described.logical_type_ref(), Some(LogicalType::Integer(kind)) if !kind.is_signed);
        Self {
            full: described.max_def_level(),
            is_list: described.max_rep_level() > 0,
            is_unsigned,
            values: Vec::new(),
            whole: Vec::new(),
            starts: Vec::new(),
            longest: 0,
            most,
        }
    }

    fn take(&mut self, reader: ColumnReader) -> Result<(), ParquetError> {
        let is_unsigned = self.is_unsigned;
        match reader {
            ColumnReader::BoolColumnReader(reader) => self.drain(reader, |x| (f64::from(u8::from(*x)), None)),
            ColumnReader::Int32ColumnReader(reader) => self.drain(reader, |x| {
                let value = if is_unsigned { f64::from(*x as u32) } else { f64::from(*x) };
                (value, Some(i64::from(*x)))
            }),
            ColumnReader::Int64ColumnReader(reader) => self.drain(reader, |x| {
                let value = if is_unsigned { *x as u64 as f64 } else { *x as f64 };
                (value, Some(*x))
            }),
            ColumnReader::FloatColumnReader(reader) => self.drain(reader, |x| (f64::from(*x), None)),
            ColumnReader::DoubleColumnReader(reader) => self.drain(reader, |x| (*x, None)),
            _ => Ok(()),
        }
    }

    fn drain<T: DataType>(
        &mut self,
        mut reader: ColumnReaderImpl<T>,
        number: impl Fn(&T::T) -> (f64, Option<i64>),
    ) -> Result<(), ParquetError> {
        let (mut levels, mut repeats, mut values) = (Vec::new(), Vec::new(), Vec::new());
        loop {
            levels.clear();
            repeats.clear();
            values.clear();
            let (records, _, _) = reader.read_records(
                BATCH,
                (self.full > 0).then_some(&mut levels),
                self.is_list.then_some(&mut repeats),
                &mut values,
            )?;
            if records == 0 {
                return Ok(());
            }
            if (self.values.len() + levels.len().max(values.len())) as u64 > self.most {
                let what = format!("it unpacks to more numbers than {}, as no log does", self.most);
                return Err(ParquetError::General(what));
            }
            let mut next = values.iter();
            let count = if self.full > 0 { levels.len() } else { values.len() };
            for i in 0..count {
                if self.is_list && repeats.get(i) == Some(&0) {
                    self.starts.push(self.values.len());
                }
                let level = levels.get(i).copied().unwrap_or(self.full);
                if level == self.full {
                    let Some(value) = next.next() else { break };
                    let (value, whole) = number(value);
                    self.values.push(value);
                    self.whole.extend(whole);
                } else if !self.is_list || level == self.full - 1 {
                    // An absent value, or an absent item of a list; an empty list has no items.
                    self.values.push(f64::NAN);
                }
                if let Some(start) = self.starts.last() {
                    self.longest = self.longest.max(self.values.len() - start);
                }
            }
        }
    }

    fn into_clock(self, name: &str, unit: Option<ClockUnit>) -> (clock::Clock, Vec<f64>) {
        if self.whole.len() == self.values.len() && !self.is_unsigned {
            clock::make_whole(name, &self.whole, unit)
        } else {
            clock::make(name, &self.values, unit)
        }
    }

    fn into_columns(self, name: &str, number: usize) -> Vec<Column> {
        if !self.is_list {
            return vec![Column { values: self.values, ..Column::new(name, number) }];
        }
        let ends = self.starts.iter().skip(1).copied().chain([self.values.len()]);
        let rows: Vec<&[f64]> =
            self.starts.iter().zip(ends).map(|(start, end)| &self.values[*start..end]).collect();
        let item = |k: usize| rows.iter().map(|row| row.get(k).copied().unwrap_or(f64::NAN)).collect();
        (0..self.longest)
            .map(|k| Column { values: item(k), ..Column::new(format!("{name}[{k}]"), number) })
            .collect()
    }
}
