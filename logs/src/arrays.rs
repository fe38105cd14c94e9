//! Arrays of NumPy: `.npy` and `.npz`.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use indexmap::IndexMap;

use crate::clock::{self, ClockUnit};
use crate::error::{LogError, LogPlace};
use crate::packed;
use crate::table::{Column, Run, Table};

const DAMAGED: &str = "the array is damaged or cut off: write it again with numpy.save or numpy.savez";
const PLAIN_TYPES: &str = "write it as numbers: array.astype(float)";
/// Largest number of columns of one array.
const MOST_COLUMNS: usize = 4096;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Kind {
    /// `f`, `i`, `u`, `b`, and `M` for a time.
    letter: u8,
    size: usize,
    is_big: bool,
}

#[derive(Debug, PartialEq)]
struct Header {
    /// Fields with their names; a plain array has one without a name.
    fields: Vec<(String, Kind)>,
    is_fortran: bool,
    shape: Vec<usize>,
}

/// An array as columns: rows are its first axis.
struct Array {
    rows: usize,
    columns: Vec<(String, Vec<f64>)>,
}

impl Array {
    /// Bytes of its numbers in memory.
    fn bytes(&self) -> u64 {
        8 * self.rows as u64 * self.columns.len() as u64
    }
}

pub(crate) fn npy(path: &Path, unit: Option<ClockUnit>) -> Result<Run, LogError> {
    let file = BufReader::new(File::open(path).map_err(LogError::open(path))?);
    let fail = |byte, what: String, remedy| LogError::damaged(path, LogPlace::Byte(byte), what, remedy);
    let array = read(file, "", u64::MAX, &fail)?;
    Ok(run(path, vec![(String::new(), array)], unit))
}

/// Reads an archive of arrays.
pub(crate) fn npz(path: &Path, unit: Option<ClockUnit>) -> Result<Run, LogError> {
    let file = File::open(path).map_err(LogError::open(path))?;
    let size = file.metadata().map_err(LogError::open(path))?.len();
    let whole = |error: zip::result::ZipError| {
        LogError::damaged(path, LogPlace::Byte(size), format!("the archive has no end: {error}"), DAMAGED)
    };
    let mut archive = zip::ZipArchive::new(BufReader::new(file)).map_err(whole)?;
    let mut arrays = Vec::new();
    let mut notes = Vec::new();
    let mut left = packed::most_bytes(size);
    for i in 0..archive.len() {
        let entry = archive.by_index(i).map_err(whole)?;
        let entry_name = entry.name().map_err(whole)?.into_owned();
        let Some(name) = entry_name.strip_suffix(".npy").map(str::to_owned) else {
            notes.push(format!("{entry_name} is left out: it is not an array"));
            continue;
        };
        let place = name.clone();
        let fail = |byte, what: String, remedy| {
            LogError::damaged(path, LogPlace::Array { name: place.clone(), byte }, what, remedy)
        };
        match read(entry, &name, left, &fail) {
            Ok(array) => {
                left = left.saturating_sub(array.bytes());
                arrays.push((name, array));
            }
            // An array of names or objects among arrays of numbers.
            Err(LogError::Damaged { what, remedy, .. }) if remedy == PLAIN_TYPES => {
                notes.push(format!("{name} is left out: {what}"));
            }
            Err(error) => return Err(error),
        }
    }
    let mut run = run(path, arrays, unit);
    run.notes.append(&mut notes);
    Ok(run)
}

/// Arrays of one length form a table; its clock is the array with a clock's name.
fn run(path: &Path, arrays: Vec<(String, Array)>, unit: Option<ClockUnit>) -> Run {
    let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let mut by_length: IndexMap<usize, Vec<Column>> = IndexMap::new();
    let mut notes = Vec::new();
    for (number, (name, array)) in arrays.into_iter().enumerate() {
        if array.rows < 2 {
            notes.push(format!("{name} is left out: it has {} rows", array.rows));
            continue;
        }
        for (own, values) in array.columns {
            let column = Column { values, ..Column::new(own, number + 1) };
            by_length.entry(array.rows).or_default().push(column);
        }
    }
    let is_alone = by_length.len() == 1;
    let mut tables = Vec::new();
    for (rows, mut columns) in by_length {
        let found = columns.iter().position(|column| clock::named(&column.name).is_some());
        let found = found.or_else(|| {
            let rises = |values: &[f64]| values.windows(2).all(|pair| pair[1] > pair[0]);
            columns.first().filter(|column| rises(&column.values)).map(|_| 0)
        });
        let mut clock = None;
        let mut times_s = Vec::new();
        if let Some(i) = found {
            let column = columns.remove(i);
            let stated = unit.or_else(|| clock::named(&column.name).and_then(|name| name.unit));
            let (made, times) = clock::make(&column.name, &column.values, stated);
            (clock, times_s) = (Some(made), times);
        }
        let name = if is_alone { stem.clone() } else { format!("{stem} ({rows} rows)") };
        tables.push(Table { name, file: path.to_owned(), clock, times_s, rows_before: 0, columns });
    }
    Run { name: stem, tables, notes }
}

/// Makes an error from a byte, the mistake there, and a remedy.
type Fail<'a> = dyn Fn(u64, String, &'static str) -> LogError + 'a;

/// Reads an array of at most `most` bytes.
fn read(mut from: impl Read, name: &str, most: u64, fail: &Fail<'_>) -> Result<Array, LogError> {
    let cut = |at: u64| move |error: std::io::Error| fail(at, format!("it ends here: {error}"), DAMAGED);
    let mut start = [0; 8];
    from.read_exact(&mut start).map_err(cut(0))?;
    if &start[..6] != b"\x93NUMPY" {
        return Err(fail(0, "the first bytes are not those of an array".into(), DAMAGED));
    }
    let wide = if start[6] > 1 { 4 } else { 2 };
    let mut length = [0; 4];
    from.read_exact(&mut length[..wide]).map_err(cut(8))?;
    let length = u32::from_le_bytes(length) as usize;
    if length > 1 << 16 {
        return Err(fail(8, format!("a header of {length} bytes"), DAMAGED));
    }
    let mut text = vec![0; length];
    let begin = 8 + wide as u64;
    from.read_exact(&mut text).map_err(cut(begin))?;
    let text = String::from_utf8_lossy(&text);
    let header = header(&text).map_err(|(what, remedy)| fail(begin, what, remedy))?;
    let rows = header.shape.first().copied().unwrap_or(1);
    let width: usize = header.shape.iter().skip(1).product();
    let item: usize = header.fields.iter().map(|(_, kind)| kind.size).sum();
    if width * header.fields.len() > MOST_COLUMNS {
        let what = format!("an array of shape {:?}: rows of {width} numbers are too wide", header.shape);
        return Err(fail(begin, what, PLAIN_TYPES));
    }
    let mut bytes = Vec::new();
    let wanted = (rows as u64).saturating_mul(width as u64).saturating_mul(item as u64);
    // Refused by its header, before anything is unpacked.
    let in_memory = (rows as u64).saturating_mul((8 * width * header.fields.len()) as u64);
    if wanted.max(in_memory) > most {
        let what = format!("an array of shape {:?}: the file is too small for these numbers", header.shape);
        return Err(fail(begin, what, DAMAGED));
    }
    from.take(wanted).read_to_end(&mut bytes).map_err(cut(begin))?;
    if (bytes.len() as u64) < wanted {
        let at = begin + length as u64 + bytes.len() as u64;
        return Err(fail(at, format!("it ends here, {} bytes early", wanted - bytes.len() as u64), DAMAGED));
    }
    Ok(Array { rows, columns: columns(name, &header, &bytes, rows, width, item) })
}

fn columns(
    name: &str,
    header: &Header,
    bytes: &[u8],
    rows: usize,
    width: usize,
    item: usize,
) -> Vec<(String, Vec<f64>)> {
    let mut columns = Vec::new();
    for w in 0..width {
        let index = header.shape[1.min(header.shape.len())..].iter().rev().scan(w, |left, size| {
            let own = *left % size.max(&1);
            *left /= size.max(&1);
            Some(own)
        });
        let index: Vec<usize> = index.collect();
        let mut path = String::new();
        for i in index.iter().rev() {
            let _ = write!(path, "[{i}]");
        }
        // In Fortran order the first axis is the fastest, and the last one the slowest.
        let slow = header
            .shape
            .iter()
            .skip(1)
            .zip(index.iter().rev())
            .rev()
            .fold(0, |sum, (size, i)| sum * size + i);
        let mut offset = 0;
        for (field, kind) in &header.fields {
            let at = |row: usize| {
                let place = if header.is_fortran { slow * rows + row } else { row * width + w };
                place * item + offset
            };
            let values = (0..rows).map(|row| number(&bytes[at(row)..at(row) + kind.size], *kind)).collect();
            let own = match (name.is_empty(), field.is_empty()) {
                (true, _) => field.clone(),
                (_, true) => name.to_owned(),
                _ => format!("{name}.{field}"),
            };
            columns.push((format!("{own}{path}"), values));
            offset += kind.size;
        }
    }
    columns
}

fn number(bytes: &[u8], kind: Kind) -> f64 {
    let mut wide = [0; 8];
    wide[..kind.size].copy_from_slice(bytes);
    if kind.is_big {
        wide[..kind.size].reverse();
    }
    let bits = u64::from_le_bytes(wide);
    match (kind.letter, kind.size) {
        (b'f', 8) => f64::from_bits(bits),
        (b'f', 4) => f64::from(f32::from_bits(bits as u32)),
        (b'f', _) => half(bits as u16),
        (b'i' | b'M', size) => {
            let spare = 64 - 8 * size as u32;
            ((bits << spare).cast_signed() >> spare) as f64
        }
        _ => bits as f64,
    }
}

/// A number of 16 bits (IEEE 754 binary16).
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let exponent = i32::from(bits >> 10 & 0x1f);
    let fraction = f64::from(bits & 0x3ff) / 1024.0;
    let is_whole = fraction.to_bits() == 0;
    match exponent {
        0 => sign * fraction * 2_f64.powi(-14),
        31 if is_whole => sign * f64::INFINITY,
        31 => f64::NAN,
        _ => sign * (1.0 + fraction) * 2_f64.powi(exponent - 15),
    }
}

/// Reads the header, a literal of Python.
fn header(text: &str) -> Result<Header, (String, &'static str)> {
    let damaged = |what: &str| (format!("the header states no {what}: {}", text.trim()), DAMAGED);
    let after = |key: &str| text.find(&format!("'{key}':")).map(|at| text[at + key.len() + 3..].trim_start());
    let shape = after("shape")
        .and_then(|rest| rest.strip_prefix('(')?.split_once(')'))
        .ok_or_else(|| damaged("shape"))?
        .0;
    let shape: Option<Vec<usize>> = shape
        .split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().ok())
        .collect();
    let shape = shape.ok_or_else(|| damaged("shape"))?;
    let size = shape.iter().try_fold(1_usize, |product, size| product.checked_mul(*size));
    if size.is_none_or(|size| size > 1 << 40) {
        return Err((format!("a shape of {shape:?}"), DAMAGED));
    }
    let is_fortran = after("fortran_order").ok_or_else(|| damaged("order"))?.starts_with("True");
    let descr = after("descr").ok_or_else(|| damaged("type"))?;
    let fields = if descr.starts_with('[') {
        let list = descr.get(1..descr.find(']').unwrap_or(1)).unwrap_or_default();
        let quoted: Vec<&str> = list.split('\'').skip(1).step_by(2).collect();
        if quoted.len() % 2 == 1 || list.matches('(').count() != quoted.len() / 2 {
            return Err((format!("fields of several numbers each: {list}"), PLAIN_TYPES));
        }
        quoted.chunks_exact(2).map(|pair| Ok((pair[0].to_owned(), kind(pair[1])?))).collect()
    } else {
        kind(descr.split('\'').nth(1).unwrap_or_default()).map(|kind| vec![(String::new(), kind)])
    };
    let fields = fields.map_err(|what| (what, PLAIN_TYPES))?;
    Ok(Header { fields, is_fortran, shape })
}

fn kind(text: &str) -> Result<Kind, String> {
    let refused = || format!("numbers of type `{text}`");
    let bytes = text.as_bytes();
    let [order, letter, size @ ..] = bytes else { return Err(refused()) };
    let digits = size.iter().take_while(|b| b.is_ascii_digit()).count();
    let size: usize = text.get(2..2 + digits).and_then(|size| size.parse().ok()).ok_or_else(refused)?;
    let is_known =
        matches!((letter, size), (b'f', 2 | 4 | 8) | (b'i' | b'u', 1 | 2 | 4 | 8) | (b'b', 1) | (b'M', 8));
    if !is_known {
        return Err(refused());
    }
    Ok(Kind { letter: *letter, size, is_big: *order == b'>' })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_half_precision_is_exact() {
        for (bits, value) in
            [(0x3c00, 1.0), (0xc000, -2.0), (0x3555, 0.333_251_953_125), (0x0001, 2_f64.powi(-24))]
        {
            assert_eq!(half(bits).to_bits(), f64::to_bits(value));
        }
        assert!(half(0x7c00).is_infinite() && half(0x7e00).is_nan());
    }

    #[test]
    fn truth_headers_of_plain_and_structured_arrays() {
        let plain = header("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }").expect("a header");
        assert_eq!((plain.shape, plain.is_fortran, plain.fields.len()), (vec![3, 2], false, 1));
        let fields = "{'descr': [('t', '<f8'), ('q', '>i2')], 'fortran_order': False, 'shape': (3,), }";
        let fields = header(fields).expect("a header").fields;
        assert_eq!(fields[1], ("q".into(), Kind { letter: b'i', size: 2, is_big: true }));
        for text in ["{}", "{'descr': '<c16', 'fortran_order': False, 'shape': (3,), }"] {
            assert!(header(text).is_err());
        }
    }
}
