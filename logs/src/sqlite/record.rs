//! A row of an SQLite table: a header of types, then the values.

use std::path::Path;

use crate::error::{LogError, LogPlace};

/// Remedy for a damaged database.
pub(super) const DAMAGED: &str =
    "the database is damaged or cut off: `sqlite3 FILE .recover` may save what is whole";

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value<'a> {
    Null,
    Int(i64),
    Real(f64),
    Text(&'a [u8]),
    Blob(&'a [u8]),
}

impl<'a> Value<'a> {
    pub(crate) fn int(self) -> Option<i64> {
        if let Self::Int(value) = self { Some(value) } else { None }
    }

    pub(crate) fn bytes(self) -> Option<&'a [u8]> {
        if let Self::Text(bytes) | Self::Blob(bytes) = self { Some(bytes) } else { None }
    }

    pub(crate) fn text(self) -> Option<&'a str> {
        std::str::from_utf8(self.bytes()?).ok()
    }
}

/// A row as it is stored.
pub(crate) struct Record<'a> {
    pub(super) path: &'a Path,
    /// Byte of the file where it begins.
    pub(super) place: u64,
    /// Number of the row.
    pub(super) number: i64,
    pub(super) bytes: &'a [u8],
}

impl<'a> Record<'a> {
    pub(super) fn values(&self) -> Result<Vec<Value<'a>>, LogError> {
        self.parsed().ok_or_else(|| {
            let what = format!("row {} holds less than its header says", self.number);
            LogError::damaged(self.path, LogPlace::Byte(self.place), what, DAMAGED)
        })
    }

    fn parsed(&self) -> Option<Vec<Value<'a>>> {
        let mut at = 0;
        let head = usize::try_from(varint(self.bytes, &mut at)?).ok()?;
        let mut body = head;
        let mut values = Vec::new();
        while at < head {
            let kind = varint(self.bytes, &mut at)?;
            let size = match kind {
                0 | 8 | 9 => 0,
                1..=4 => kind as usize,
                5 => 6,
                6 | 7 => 8,
                12.. => usize::try_from((kind - 12) / 2).ok()?,
                _ => return None,
            };
            let bytes = self.bytes.get(body..body.checked_add(size)?)?;
            body += size;
            values.push(match kind {
                0 => Value::Null,
                8 => Value::Int(0),
                9 => Value::Int(1),
                7 => Value::Real(f64::from_bits(unsigned(bytes))),
                1..=6 => {
                    let spare = 64 - 8 * size as u32;
                    Value::Int((unsigned(bytes) << spare).cast_signed() >> spare)
                }
                _ if kind % 2 == 0 => Value::Blob(bytes),
                _ => Value::Text(bytes),
            });
        }
        Some(values)
    }
}

fn unsigned(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0, |value, byte| value << 8 | u64::from(*byte))
}

/// A number of one to nine bytes.
pub(super) fn varint(bytes: &[u8], at: &mut usize) -> Option<i64> {
    let mut value = 0_u64;
    for i in 0..9 {
        let byte = *bytes.get(*at)?;
        *at += 1;
        if i == 8 {
            return Some((value << 8 | u64::from(byte)).cast_signed());
        }
        value = value << 7 | u64::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            return Some(value.cast_signed());
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_numbers_of_variable_length() {
        let read = |bytes: &[u8]| varint(bytes, &mut 0);
        assert_eq!(read(&[0x7f]), Some(127));
        assert_eq!(read(&[0x81, 0x00]), Some(128));
        assert_eq!(read(&[0xff; 9]), Some(-1));
        assert_eq!(read(&[0x80]), None);
    }
}
