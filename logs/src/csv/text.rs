//! The text of a table: its encoding, its first lines, and its split rows.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::Path;

use csv::ByteRecord;

use super::dialect::{Dialect, Separator};
use crate::error::{LogError, LogPlace};

/// Number of bytes from which the layout of a table is guessed.
const SAMPLE_BYTES: usize = 1 << 17;

/// A text in UTF-8, or in an encoding with the same digits.
pub(super) struct Text {
    /// The first lines.
    pub(super) sample: Vec<u8>,
    rest: Box<dyn Read>,
}

impl Text {
    pub(super) fn open(path: &Path) -> Result<Self, LogError> {
        let mut file = File::open(path).map_err(LogError::open(path))?;
        let mut sample = vec![0; SAMPLE_BYTES];
        let read = fill(&mut file, &mut sample).map_err(LogError::open(path))?;
        sample.truncate(read);
        if let Some(from_le) = utf_16(&sample) {
            let mut bytes = sample;
            file.read_to_end(&mut bytes).map_err(LogError::open(path))?;
            let text = decode_utf_16(&bytes, from_le).map_err(|byte| {
                LogError::damaged(path, LogPlace::Byte(byte), "this is not UTF-16", "save the table as UTF-8")
            })?;
            let text = text.into_bytes();
            let sample = text[..text.len().min(SAMPLE_BYTES)].to_vec();
            let rest = Cursor::new(text[sample.len()..].to_vec());
            return Ok(Self { sample, rest: Box::new(rest) });
        }
        if sample.starts_with(b"\xef\xbb\xbf") {
            sample.drain(..3);
        }
        if let Some(byte) = sample.iter().position(|b| *b == 0) {
            let remedy = "name a table of numbers, or a log that `feeler import` reads";
            return Err(LogError::other(
                path,
                format!("it is not a text with columns (byte {byte} is zero)"),
                remedy,
            ));
        }
        Ok(Self { sample, rest: Box::new(file) })
    }

    /// The rows, from the first line onwards.
    pub(super) fn rows(self, dialect: &Dialect) -> Rows {
        let whole = Cursor::new(self.sample).chain(self.rest);
        Rows::of(Box::new(whole), dialect)
    }
}

/// Reads until the buffer is full or the file ends.
fn fill(file: &mut File, buffer: &mut [u8]) -> std::io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match file.read(&mut buffer[filled..])? {
            0 => break,
            n => filled += n,
        }
    }
    Ok(filled)
}

/// Whether a text is UTF-16, and if so, whether its low bytes come first.
fn utf_16(sample: &[u8]) -> Option<bool> {
    match sample {
        [0xff, 0xfe, ..] => Some(true),
        [0xfe, 0xff, ..] => Some(false),
        [low, 0, other, 0, ..] if *low != 0 && *other != 0 => Some(true),
        [0, low, 0, other, ..] if *low != 0 && *other != 0 => Some(false),
        _ => None,
    }
}

/// The text, or the byte at which it is invalid.
fn decode_utf_16(bytes: &[u8], from_le: bool) -> Result<String, u64> {
    if bytes.len() % 2 == 1 {
        return Err(bytes.len() as u64 - 1);
    }
    let units = bytes.chunks_exact(2).map(|pair| {
        let pair = [pair[0], pair[1]];
        if from_le { u16::from_le_bytes(pair) } else { u16::from_be_bytes(pair) }
    });
    let mut text = String::with_capacity(bytes.len() / 2);
    let mut at = 0;
    for unit in char::decode_utf16(units) {
        let c = unit.map_err(|_| at)?;
        at += 2 * c.len_utf16() as u64;
        if c != '\u{feff}' {
            text.push(c);
        }
    }
    Ok(text)
}

/// Rows of a table, split into cells.
pub(super) enum Rows {
    Split(Box<csv::Reader<Box<dyn Read>>>),
    /// Cells between any number of blanks.
    Blanks {
        lines: BufReader<Box<dyn Read>>,
        line: Vec<u8>,
        comment: u8,
    },
}

impl Rows {
    pub(super) fn of(text: Box<dyn Read>, dialect: &Dialect) -> Self {
        match dialect.separator {
            Separator::Blanks => {
                Self::Blanks { lines: BufReader::new(text), line: Vec::new(), comment: dialect.comment }
            }
            Separator::Mark(mark) => Self::Split(Box::new(
                csv::ReaderBuilder::new()
                    .delimiter(mark)
                    .has_headers(false)
                    .flexible(true)
                    .comment(Some(dialect.comment))
                    .buffer_capacity(1 << 16)
                    .from_reader(text),
            )),
        }
    }

    /// The next row; false at the end.
    pub(super) fn next(&mut self, record: &mut ByteRecord) -> Result<bool, csv::Error> {
        match self {
            Self::Split(reader) => reader.read_byte_record(record),
            Self::Blanks { lines, line, comment } => loop {
                line.clear();
                if lines.read_until(b'\n', line)? == 0 {
                    return Ok(false);
                }
                record.clear();
                let cells = line.split(u8::is_ascii_whitespace).filter(|cell| !cell.is_empty());
                cells.for_each(|cell| record.push_field(cell));
                if record.get(0).is_some_and(|cell| cell[0] != *comment) {
                    return Ok(true);
                }
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_utf_16_is_told_by_its_mark_or_its_zeros() {
        let le = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
        assert_eq!(utf_16(&le("t;x")), Some(true));
        assert_eq!(utf_16(b"\xfe\xff\0t"), Some(false));
        assert_eq!(utf_16(b"t;x\n"), None);
        assert_eq!(decode_utf_16(&le("\u{feff}µ 𝄞"), true).as_deref(), Ok("µ 𝄞"));
        // A high surrogate without its low one.
        assert_eq!(decode_utf_16(&[b't', 0, 0x00, 0xd8], true), Err(2));
        assert_eq!(decode_utf_16(&[b't', 0, 1], true), Err(2));
    }
}
