//! MCAP logs (mcap.dev): messages in JSON or CDR, chunks plain or compressed by lz4 or zstd.

use std::io::{BufReader, Read};
use std::path::Path;

use mcap::McapError;
use mcap::sans_io::LinearReaderOptions;
use mcap::sans_io::message_reader::{MessageReadEvent, MessageReader};

use crate::error::{LogError, LogPlace};
use crate::packed;
use crate::topics::{Declared, Topics};

const DAMAGED: &str =
    "the log is damaged or cut off: `mcap recover` may save what is whole, else record it again";

const COMPRESSION: &str = "write it with zstd, lz4 or without compression, as `mcap compress` does; if that \
                           name means nothing, the log is damaged";

/// Largest ratio of decompressed to compressed size of a record: lz4 reaches 255; short records exceed it.
const GROWTH: u64 = 256;
/// Limits on the length of one record, in bytes. A damaged length would only reserve memory.
const RECORD_BYTES: [u64; 2] = [1 << 24, 1 << 30];

/// Reads the messages of a log. Channels are numbered from `base` onwards; returns the number of used ones.
pub(crate) fn read(path: &Path, topics: &mut Topics, base: u64) -> Result<(), LogError> {
    let file = packed::open(path)?;
    let size = file.metadata().map_err(LogError::open(path))?.len();
    let mut file = BufReader::with_capacity(1 << 20, file);
    let longest = size.saturating_mul(GROWTH).clamp(RECORD_BYTES[0], RECORD_BYTES[1]);
    // A chunk's checksum is tested first: the reader subtracts damaged lengths without a check.
    let options = LinearReaderOptions::default()
        .with_record_length_limit(longest as usize)
        .with_prevalidate_chunk_crcs(true);
    let mut reader = MessageReader::new_with_options(options);
    let mut at = 0_u64;
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| said(path, at, &error))? {
            MessageReadEvent::ReadRequest(wanted) => {
                // A length beyond the end of the file would only reserve memory.
                let left = size.saturating_sub(at) as usize;
                if wanted > left.saturating_add(1 << 16) {
                    let what = format!("a record of {wanted} bytes, though {left} are left");
                    return Err(LogError::damaged(path, LogPlace::Byte(at), what, DAMAGED));
                }
                let read = file.read(reader.insert(wanted)).map_err(LogError::open(path))?;
                reader.notify_read(read);
                at += read as u64;
            }
            MessageReadEvent::Message(message) => {
                let channel = &message.channel;
                let id = base + u64::from(channel.id);
                if !topics.has(id) {
                    let schema = channel.schema.as_ref();
                    let text = schema.and_then(|schema| std::str::from_utf8(&schema.data).ok());
                    topics.declare(
                        id,
                        &Declared {
                            name: &channel.topic,
                            encoding: &channel.message_encoding,
                            schema_name: schema.map_or("", |schema| &schema.name),
                            schema_encoding: schema.map_or("", |schema| &schema.encoding),
                            schema: text.filter(|text| !text.trim().is_empty()),
                        },
                    );
                }
                topics.push(path, id, message.log_time.cast_signed(), &message.data)?;
            }
        }
    }
    Ok(())
}

fn said(path: &Path, at: u64, error: &McapError) -> LogError {
    let (what, remedy) = match error {
        // Of a damaged log this may be any text.
        McapError::UnsupportedCompression(with) => {
            (format!("a chunk is compressed by {with:?}"), COMPRESSION)
        }
        _ => (error.to_string(), DAMAGED),
    };
    LogError::damaged(path, LogPlace::Byte(at), format!("at or before this byte: {what}"), remedy)
}
