//! Common data representation (OMG, DDS-XTypes 1.3, 7.4): plain CDR of both versions and both byte orders.

use super::definition::{Base, Definition, Many};

/// Numbers of one message, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Numbers {
    pub(crate) values: Vec<f64>,
    /// Lengths of sequences.
    pub(crate) lengths: Vec<u32>,
    /// Texts of lists of names, with a zero byte after each.
    pub(crate) names: Vec<u8>,
    /// The time in the header.
    pub(crate) stamp_ns: Option<i64>,
}

/// A mistake in a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CdrError {
    pub(crate) byte: usize,
    pub(crate) what: String,
}

/// Longer lists of numbers are pictures, scans or maps, and not columns.
pub(super) const LONGEST_LIST: usize = 256;

/// Bytes of the header with byte order and version.
const HEADER: usize = 4;
/// Bytes that a writer may add so that the length is a multiple of eight.
const PADDING: usize = 7;

/// Whether a list of texts names the items of other lists.
pub(super) fn names_items(field: &str) -> bool {
    field.ends_with("name") || field.ends_with("names")
}

pub(super) fn decode(definition: &Definition, message: &[u8], into: &mut Numbers) -> Result<(), CdrError> {
    into.values.clear();
    into.lengths.clear();
    into.names.clear();
    into.stamp_ns = None;
    let Some(header) = message.get(..HEADER) else {
        return Err(CdrError { byte: message.len(), what: "the message has no header".into() });
    };
    let (is_little, widest) = match (header[0], header[1]) {
        (0, 0) => (false, 8),
        (0, 1) => (true, 8),
        (0, 6) => (false, 4),
        (0, 7) => (true, 4),
        (high, low) => {
            let what = format!("representation {high:#04x}{low:02x} is not plain CDR");
            return Err(CdrError { byte: 0, what });
        }
    };
    let mut reader = Reader { bytes: message, at: HEADER, is_little, widest, definition, into };
    if definition.has_header() {
        let mut ahead = Reader { at: HEADER, ..reader };
        let seconds = ahead.signed::<4>()?;
        let nanos = ahead.unsigned::<4>()?;
        ahead.into.stamp_ns = Some(seconds * 1_000_000_000 + nanos.cast_signed());
        reader = Reader { at: HEADER, ..ahead };
    }
    reader.structure(definition.root)?;
    let left = message.len() - reader.at;
    if left > PADDING {
        let what = format!("{left} bytes are left over: the definition is not that of this message");
        return Err(CdrError { byte: reader.at, what });
    }
    Ok(())
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    is_little: bool,
    widest: usize,
    definition: &'a Definition,
    into: &'a mut Numbers,
}

impl<'a> Reader<'a> {
    fn error(&self, what: impl Into<String>) -> CdrError {
        CdrError { byte: self.at, what: what.into() }
    }

    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn align(&mut self, size: usize) {
        let size = size.min(self.widest);
        let over = (self.at - HEADER) % size;
        if over > 0 {
            self.at = (self.at + size - over).min(self.bytes.len());
        }
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], CdrError> {
        if self.left() < count {
            return Err(self.error(format!("the message ends {} bytes early", count - self.left())));
        }
        let taken = &self.bytes[self.at..self.at + count];
        self.at += count;
        Ok(taken)
    }

    /// A number of N bytes in this machine's order, aligned.
    fn fixed<const N: usize>(&mut self) -> Result<[u8; N], CdrError> {
        self.align(N);
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        if !self.is_little {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn unsigned<const N: usize>(&mut self) -> Result<u64, CdrError> {
        let mut wide = [0; 8];
        wide[..N].copy_from_slice(&self.fixed::<N>()?);
        Ok(u64::from_le_bytes(wide))
    }

    fn signed<const N: usize>(&mut self) -> Result<i64, CdrError> {
        let spare = 64 - 8 * N as u32;
        Ok((self.unsigned::<N>()? << spare).cast_signed() >> spare)
    }

    fn length(&mut self) -> Result<usize, CdrError> {
        let start = self.at;
        let length = self.unsigned::<4>()? as usize;
        // Every item has at least one byte.
        if length > self.left() {
            let what = format!("a length of {length}, though {} bytes are left", self.left());
            return Err(CdrError { byte: start, what });
        }
        Ok(length)
    }

    fn text(&mut self) -> Result<&'a [u8], CdrError> {
        let length = self.length()?;
        let text = self.take(length)?;
        Ok(text.strip_suffix(b"\0").unwrap_or(text))
    }

    fn number(&mut self, base: Base) -> Result<f64, CdrError> {
        Ok(match base {
            Base::Bool | Base::U8 => self.unsigned::<1>()? as f64,
            Base::I8 => self.signed::<1>()? as f64,
            Base::U16 => self.unsigned::<2>()? as f64,
            Base::I16 => self.signed::<2>()? as f64,
            Base::U32 => self.unsigned::<4>()? as f64,
            Base::I32 => self.signed::<4>()? as f64,
            Base::U64 => self.unsigned::<8>()? as f64,
            Base::I64 => self.signed::<8>()? as f64,
            Base::F32 => f64::from(f32::from_le_bytes(self.fixed()?)),
            Base::F64 => f64::from_le_bytes(self.fixed()?),
            Base::Text | Base::Struct(_) => return Err(self.error("this is not a number")),
        })
    }

    fn structure(&mut self, index: usize) -> Result<(), CdrError> {
        let definition = self.definition;
        let fields = &definition.structs[index].fields;
        // A structure without members is written with one meaningless member.
        if fields.is_empty() {
            return self.take(1).map(drop);
        }
        for field in fields {
            let count = match field.many {
                Many::One => 1,
                Many::Fixed(count) => count,
                Many::Sequence => {
                    let length = self.length()?;
                    self.into.lengths.push(length as u32);
                    length
                }
            };
            match field.base {
                Base::Struct(inner) => {
                    for _ in 0..count {
                        self.structure(inner)?;
                    }
                }
                Base::Text => {
                    for _ in 0..count {
                        let text = self.text()?;
                        if field.many != Many::One && names_items(&field.name) {
                            self.into.names.extend_from_slice(text);
                            self.into.names.push(0);
                        }
                    }
                }
                base if count > LONGEST_LIST => self.skip(base, count)?,
                base => {
                    for _ in 0..count {
                        let value = self.number(base)?;
                        self.into.values.push(value);
                    }
                }
            }
        }
        Ok(())
    }

    /// Passes over a long list.
    fn skip(&mut self, base: Base, count: usize) -> Result<(), CdrError> {
        let size = match base {
            Base::U16 | Base::I16 => 2,
            Base::U32 | Base::I32 | Base::F32 => 4,
            Base::U64 | Base::I64 | Base::F64 => 8,
            _ => 1,
        };
        self.align(size);
        self.take(count.saturating_mul(size)).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::definition::{Field, Struct};
    use super::*;

    const BASES: [Base; 12] = [
        Base::Bool,
        Base::U8,
        Base::I8,
        Base::U16,
        Base::I16,
        Base::U32,
        Base::I32,
        Base::U64,
        Base::I64,
        Base::F32,
        Base::F64,
        Base::Text,
    ];

    /// Messages of up to three structures, each of which may hold the next; the second is a header by name.
    fn definitions() -> impl Strategy<Value = Definition> {
        let field = (0..BASES.len() + 3, 0..4, 0_usize..5, any::<bool>());
        let structs = prop::collection::vec(prop::collection::vec(field, 0..5), 1..4);
        structs.prop_map(|structs| {
            let count = structs.len();
            let of = |(own, fields): (usize, Vec<(usize, i32, usize, bool)>)| Struct {
                name: if own == 1 { "std_msgs/Header".into() } else { format!("demo/S{own}") },
                fields: fields
                    .into_iter()
                    .map(|(base, many, length, is_name)| Field {
                        name: if is_name { "name" } else { "value" }.into(),
                        base: BASES.get(base).copied().unwrap_or(if own + 1 < count {
                            Base::Struct(own + 1)
                        } else {
                            Base::U8
                        }),
                        many: match many {
                            0 | 1 => Many::One,
                            2 => Many::Fixed(length),
                            _ => Many::Sequence,
                        },
                    })
                    .collect(),
            };
            Definition { structs: structs.into_iter().enumerate().map(of).collect(), root: 0 }
        })
    }

    /// Bytes after a header of one of the four plain representations. Small numbers are plausible lengths.
    fn messages() -> impl Strategy<Value = Vec<u8>> {
        let byte = prop_oneof![3 => Just(0_u8), 2 => 0..6_u8, 1 => any::<u8>()];
        let kind = prop::sample::select(vec![0_u8, 1, 6, 7]);
        (kind, prop::collection::vec(byte, 0..120)).prop_map(|(kind, body)| {
            let mut message = vec![0, kind, 0, 0];
            message.extend(body);
            message
        })
    }

    proptest! {
        #[test]
        fn prop_any_message_of_any_definition_gives_numbers_or_the_byte_of_the_mistake(
            definition in definitions().prop_filter_map("it is sound", |found| found.checked().ok()),
            message in messages(),
        ) {
            let mut numbers = Numbers::default();
            match decode(&definition, &message, &mut numbers) {
                // Each number takes a byte at least, and padding is short.
                Ok(()) => prop_assert!(numbers.values.len() <= message.len() - HEADER),
                Err(error) => prop_assert!(
                    error.byte <= message.len() && !error.what.is_empty(),
                    "{:?} in {} bytes", error, message.len()
                ),
            }
            // A message that is cut off inside its header is not a message either.
            for end in 0..HEADER {
                let error = decode(&definition, &message[..end], &mut numbers);
                prop_assert!(error.is_err_and(|error| error.byte == end));
            }
        }

        #[test]
        fn prop_bytes_of_no_plain_representation_are_refused_at_their_start(message: Vec<u8>) {
            let plain = [[0, 0], [0, 1], [0, 6], [0, 7]];
            let is_plain = message.len() >= HEADER && plain.iter().any(|kind| message.starts_with(kind));
            let definition = Definition { structs: vec![Struct::default()], root: 0 };
            if !is_plain {
                let error = decode(&definition, &message, &mut Numbers::default()).err();
                let place = if message.len() < HEADER { message.len() } else { 0 };
                prop_assert_eq!(error.map(|error| error.byte), Some(place));
            }
        }
    }
}
