//! Tables of results, and their Parquet files.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use feeler_files::Setting;
use indexmap::IndexMap;
use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::column::reader::ColumnReader;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::axes::shown;
use super::error::SweepError;

/// Smallest number of rows of a row group, if there are enough rows.
const ROWS_PER_GROUP: usize = 1 << 14;
/// Number of list entries at which a row group ends, whatever its number of rows.
const ENTRIES_PER_GROUP: usize = 1 << 20;

/// One column.
#[derive(Clone, Debug, PartialEq)]
pub enum SweepColumn {
    Whole(Vec<i64>),
    /// Numbers, some absent.
    Real(Vec<Option<f64>>),
    /// Texts, some absent.
    Text(Vec<Option<String>>),
    List(Vec<Vec<f64>>),
}

impl SweepColumn {
    fn empty_like(&self) -> Self {
        match self {
            Self::Whole(_) => Self::Whole(Vec::new()),
            Self::Real(_) => Self::Real(Vec::new()),
            Self::Text(_) => Self::Text(Vec::new()),
            Self::List(_) => Self::List(Vec::new()),
        }
    }

    fn append(&mut self, other: Self) {
        match (self, other) {
            (Self::Whole(mine), Self::Whole(more)) => mine.extend(more),
            (Self::Real(mine), Self::Real(more)) => mine.extend(more),
            (Self::Text(mine), Self::Text(more)) => mine.extend(more),
            (Self::List(mine), Self::List(more)) => mine.extend(more),
            // Tables of one sweep have the same columns.
            _ => {}
        }
    }

    /// Number of entries of its lists.
    fn entries(&self) -> usize {
        if let Self::List(lists) = self { lists.iter().map(Vec::len).sum() } else { 0 }
    }

    /// Keeps the rows that are marked.
    fn retain(&mut self, marked: &[bool]) {
        fn kept<T>(values: &mut Vec<T>, marked: &[bool]) {
            let mut marks = marked.iter();
            values.retain(|_| marks.next().is_some_and(|mark| *mark));
        }
        match self {
            Self::Whole(values) => kept(values, marked),
            Self::Real(values) => kept(values, marked),
            Self::Text(values) => kept(values, marked),
            Self::List(values) => kept(values, marked),
        }
    }

    fn field(&self, name: &str) -> Result<Type, ParquetError> {
        let builder = |kind, repetition| Type::primitive_type_builder(name, kind).with_repetition(repetition);
        match self {
            Self::Whole(_) => builder(PhysicalType::INT64, Repetition::REQUIRED).build(),
            Self::Real(_) => builder(PhysicalType::DOUBLE, Repetition::OPTIONAL).build(),
            Self::Text(_) => builder(PhysicalType::BYTE_ARRAY, Repetition::OPTIONAL)
                .with_logical_type(Some(LogicalType::String))
                .build(),
            Self::List(_) => builder(PhysicalType::DOUBLE, Repetition::REPEATED).build(),
        }
    }
}

/// Columns of equal length under their names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepTable {
    pub columns: IndexMap<String, SweepColumn>,
    pub rows: usize,
}

impl SweepTable {
    /// The numbers of a column; `None` if there is no such column of numbers.
    pub fn reals(&self, name: &str) -> Option<Vec<Option<f64>>> {
        match self.columns.get(name)? {
            SweepColumn::Real(values) => Some(values.clone()),
            SweepColumn::Whole(values) => Some(values.iter().map(|&value| Some(value as f64)).collect()),
            _ => None,
        }
    }

    /// The texts of a column; `None` if there is no such column of texts.
    pub fn texts(&self, name: &str) -> Option<&[Option<String>]> {
        if let SweepColumn::Text(values) = self.columns.get(name)? { Some(values) } else { None }
    }

    /// The lists of a column; `None` if there is no such column of lists.
    pub fn lists(&self, name: &str) -> Option<&[Vec<f64>]> {
        if let SweepColumn::List(values) = self.columns.get(name)? { Some(values) } else { None }
    }

    /// The rows with all of some settings.
    pub fn rows_with(&self, settings: &[(String, Setting)]) -> Vec<usize> {
        let has = |row: usize, key: &str, setting: &Setting| match self.columns.get(key) {
            Some(SweepColumn::Text(texts)) => texts[row].as_ref().is_some_and(|text| *text == shown(setting)),
            Some(SweepColumn::Real(values)) => {
                let bits = values[row].map(f64::to_bits);
                matches!(setting, Setting::Number(number) if bits == Some(number.to_bits()))
            }
            _ => false,
        };
        (0..self.rows).filter(|&row| settings.iter().all(|(key, setting)| has(row, key, setting))).collect()
    }

    fn append(&mut self, other: Self) {
        if self.columns.is_empty() {
            *self = other;
            return;
        }
        self.rows += other.rows;
        for (name, more) in other.columns {
            if let Some(mine) = self.columns.get_mut(&name) {
                mine.append(more);
            }
        }
    }

    /// Reads a whole file.
    ///
    /// # Errors
    /// A file that cannot be read, or is not a table of a sweep.
    pub fn read(path: &Path) -> Result<Self, SweepError> {
        Self::read_part(path, &|_| true, &|_| true)
    }

    /// Reads the requested columns and rows, by name and by number. It never holds more than a part of the
    /// others.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_part(
        path: &Path,
        column: &dyn Fn(&str) -> bool,
        row: &dyn Fn(usize) -> bool,
    ) -> Result<Self, SweepError> {
        let mut table = Self::default();
        scan(path, column, row, &mut |first, mut part: Self| {
            let marked: Vec<bool> = (first..first + part.rows).map(row).collect();
            part.columns.values_mut().for_each(|column| column.retain(&marked));
            part.rows = marked.iter().filter(|mark| **mark).count();
            table.append(part);
        })?;
        Ok(table)
    }

    /// Reads the requested columns of a file part by part. `visit` receives each part with the number of its
    /// first row.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn scan(
        path: &Path,
        column: &dyn Fn(&str) -> bool,
        visit: &mut dyn FnMut(usize, Self),
    ) -> Result<(), SweepError> {
        scan(path, column, &|_| true, visit)
    }

    /// Number of rows of a file, from its footer.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn count_rows(path: &Path) -> Result<usize, SweepError> {
        let file = File::open(path).map_err(SweepError::io(path))?;
        let reader = SerializedFileReader::new(file).map_err(SweepError::parquet(path))?;
        Ok(reader.metadata().file_metadata().num_rows() as usize)
    }
}

/// Writes tables with the same columns one after another. The sizes of row groups do not depend on the sizes
/// of these tables.
pub(super) struct TableWriter {
    file: SerializedFileWriter<File>,
    waiting: SweepTable,
    /// Number of list entries that wait.
    entries: usize,
}

impl TableWriter {
    /// A file with the columns of `like`.
    pub(super) fn new(file: File, like: &SweepTable) -> Result<Self, ParquetError> {
        let fields = like
            .columns
            .iter()
            .map(|(name, column)| column.field(name).map(Arc::new))
            .collect::<Result<_, _>>()?;
        let schema = Arc::new(Type::group_type_builder("sweep").with_fields(fields).build()?);
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by("feeler".into())
            .build();
        let columns = like.columns.iter().map(|(name, column)| (name.clone(), column.empty_like())).collect();
        let waiting = SweepTable { columns, rows: 0 };
        Ok(Self { file: SerializedFileWriter::new(file, schema, Arc::new(properties))?, waiting, entries: 0 })
    }

    pub(super) fn add(&mut self, table: SweepTable) -> Result<(), ParquetError> {
        self.entries += table.columns.values().map(SweepColumn::entries).sum::<usize>();
        self.waiting.append(table);
        if self.waiting.rows >= ROWS_PER_GROUP || self.entries >= ENTRIES_PER_GROUP {
            self.flush()
        } else {
            Ok(())
        }
    }

    /// Ends the file and returns it for synchronisation.
    pub(super) fn finish(mut self) -> Result<File, ParquetError> {
        if self.waiting.rows > 0 {
            self.flush()?;
        }
        self.file.into_inner()
    }

    fn flush(&mut self) -> Result<(), ParquetError> {
        let mut group = self.file.next_row_group()?;
        for column in self.waiting.columns.values_mut() {
            let Some(mut writer) = group.next_column()? else { break };
            match column {
                SweepColumn::Whole(values) => {
                    writer.typed::<Int64Type>().write_batch(values, None, None)?;
                }
                SweepColumn::Real(values) => {
                    let present: Vec<f64> = values.iter().flatten().copied().collect();
                    writer.typed::<DoubleType>().write_batch(&present, Some(&definition(values)), None)?;
                }
                SweepColumn::Text(values) => {
                    let present: Vec<ByteArray> =
                        values.iter().flatten().map(|text| ByteArray::from(text.as_str())).collect();
                    writer.typed::<ByteArrayType>().write_batch(&present, Some(&definition(values)), None)?;
                }
                SweepColumn::List(lists) => {
                    let values: Vec<f64> = lists.iter().flatten().copied().collect();
                    // An empty list is one undefined entry; a list begins at repetition 0.
                    let levels = lists.iter().flat_map(|list| {
                        (0..list.len().max(1)).map(|i| (i16::from(!list.is_empty()), i16::from(i > 0)))
                    });
                    let (definition, repetition): (Vec<i16>, Vec<i16>) = levels.unzip();
                    writer.typed::<DoubleType>().write_batch(
                        &values,
                        Some(&definition),
                        Some(&repetition),
                    )?;
                }
            }
            writer.close()?;
            *column = column.empty_like();
        }
        self.waiting.rows = 0;
        self.entries = 0;
        group.close()?;
        Ok(())
    }
}

fn definition<T>(values: &[Option<T>]) -> Vec<i16> {
    values.iter().map(|value| i16::from(value.is_some())).collect()
}

/// Visits the parts of a file that hold a wanted row, with their wanted columns.
fn scan(
    path: &Path,
    wanted: &dyn Fn(&str) -> bool,
    row: &dyn Fn(usize) -> bool,
    visit: &mut dyn FnMut(usize, SweepTable),
) -> Result<(), SweepError> {
    let file = File::open(path).map_err(SweepError::io(path))?;
    let visit_all = || -> Result<(), ParquetError> {
        let reader = SerializedFileReader::new(file)?;
        if reader.num_row_groups() == 0 {
            return Err(ParquetError::General("the file has no rows".into()));
        }
        let mut first = 0;
        for group in 0..reader.num_row_groups() {
            let group = reader.get_row_group(group)?;
            let rows = group.metadata().num_rows() as usize;
            if (first..first + rows).any(row) {
                let mut columns = IndexMap::new();
                let described = group.metadata().schema_descr().columns().iter().enumerate();
                for (i, described) in described.filter(|(_, described)| wanted(described.name())) {
                    let values = column(group.get_column_reader(i)?, rows, described.max_rep_level() > 0)?;
                    columns.insert(described.name().to_owned(), values);
                }
                visit(first, SweepTable { columns, rows });
            }
            first += rows;
        }
        Ok(())
    };
    visit_all().map_err(SweepError::parquet(path))
}

fn column(reader: ColumnReader, rows: usize, repeated: bool) -> Result<SweepColumn, ParquetError> {
    let (mut definition, mut repetition) = (Vec::new(), Vec::new());
    match reader {
        ColumnReader::Int64ColumnReader(mut reader) => {
            let mut values = Vec::new();
            reader.read_records(rows, None, None, &mut values)?;
            Ok(SweepColumn::Whole(values))
        }
        ColumnReader::DoubleColumnReader(mut reader) => {
            let mut values = Vec::new();
            reader.read_records(
                rows,
                Some(&mut definition),
                repeated.then_some(&mut repetition),
                &mut values,
            )?;
            if !repeated {
                return Ok(SweepColumn::Real(spread(&definition, values)));
            }
            let mut lists: Vec<Vec<f64>> = Vec::new();
            let mut values = values.into_iter();
            for (defined, repeats) in definition.iter().zip(&repetition) {
                if *repeats == 0 {
                    lists.push(Vec::new());
                }
                if let (1, Some(list)) = (defined, lists.last_mut()) {
                    list.extend(values.next());
                }
            }
            Ok(SweepColumn::List(lists))
        }
        ColumnReader::ByteArrayColumnReader(mut reader) => {
            let mut values = Vec::new();
            reader.read_records(rows, Some(&mut definition), None, &mut values)?;
            let texts = values
                .iter()
                .map(|value| Ok(value.as_utf8()?.to_owned()))
                .collect::<Result<Vec<_>, ParquetError>>()?;
            Ok(SweepColumn::Text(spread(&definition, texts)))
        }
        _ => Err(ParquetError::General("a sweep has no columns of this kind".into())),
    }
}

/// Values at the positions whose definition level marks a value.
fn spread<T>(definition: &[i16], values: Vec<T>) -> Vec<Option<T>> {
    let mut values = values.into_iter();
    definition.iter().map(|&defined| if defined > 0 { values.next() } else { None }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_what_is_written_is_read() {
        let columns = [
            ("variant", SweepColumn::Whole(vec![3, 4, 5])),
            ("kp", SweepColumn::Real(vec![Some(0.1), None, Some(-3.0)])),
            ("outcome", SweepColumn::Text(vec![Some("settled".into()), Some(String::new()), None])),
            ("peaks", SweepColumn::List(vec![vec![1.0, 2.0], vec![], vec![3.0]])),
        ];
        let table = SweepTable {
            columns: columns.into_iter().map(|(name, column)| (name.to_owned(), column)).collect(),
            rows: 3,
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.parquet");
        let mut writer = TableWriter::new(File::create(&path).unwrap(), &table).unwrap();
        writer.add(table.clone()).unwrap();
        writer.add(table.clone()).unwrap();
        writer.finish().unwrap();
        let read = SweepTable::read(&path).unwrap();
        assert_eq!(read.rows, 6);
        assert_eq!(read.lists("peaks").unwrap()[3..], table.lists("peaks").unwrap()[..]);
        assert_eq!(read.texts("outcome").unwrap()[..3], table.texts("outcome").unwrap()[..]);
        assert_eq!(read.reals("kp").unwrap()[3..], table.reals("kp").unwrap()[..]);
        assert_eq!(read.columns["variant"], SweepColumn::Whole(vec![3, 4, 5, 3, 4, 5]));
        assert_eq!(SweepTable::count_rows(&path).unwrap(), 6);
        let part =
            SweepTable::read_part(&path, &|name| ["variant", "peaks"].contains(&name), &|row| row % 2 == 1)
                .unwrap();
        assert_eq!((part.rows, part.columns.len()), (3, 2));
        assert_eq!(part.columns["variant"], SweepColumn::Whole(vec![4, 3, 5]));
        assert_eq!(part.lists("peaks").unwrap(), [vec![], vec![1.0, 2.0], vec![3.0]]);
    }
}
