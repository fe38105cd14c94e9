//! Long logs are read once, and held in memory once: what bounds time and memory of an import, without a
//! clock. In a process of its own, since both are counted for a whole process.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::io::{Cursor, Write as _};
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use parquet::data_type::DoubleType;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;

/// A minute of 40 channels at 1 kHz. The bound for 900 s is 500 MB, where the numbers take 295 MB.
const ROWS: usize = 60_000;
const CHANNELS: usize = 40;
const NUMBERS: u64 = 8 * (CHANNELS as u64 + 1) * ROWS as u64;
/// Largest memory over that of the numbers; some megabytes are buffers.
const MOST_MEMORY: f64 = 1.7;
/// Largest number of bytes read over that of the file: its first ones tell its kind.
const MOST_READ: f64 = 1.1;
const BUFFERS: u64 = 4 << 20;

fn channel(k: usize, c: usize) -> f64 {
    // As many digits as a logger writes.
    ((k * (c + 3)) as f64 * 1e-3).sin()
}

fn csv() -> Vec<u8> {
    let mut text = "t_s".to_owned();
    (0..CHANNELS).for_each(|c| write!(text, ",q{c}").expect("written"));
    for k in 0..ROWS {
        write!(text, "\n{}", k as f64 * 1e-3).expect("written");
        (0..CHANNELS).for_each(|c| write!(text, ",{:.6}", channel(k, c)).expect("written"));
    }
    text.into_bytes()
}

fn parquet_table() -> Vec<u8> {
    let names = (0..CHANNELS).fold("required double t_s;".to_owned(), |mut text, c| {
        write!(text, " required double q{c};").expect("written");
        text
    });
    let schema = parquet::schema::parser::parse_message_type(&format!("message rows {{ {names} }}"));
    let properties = WriterProperties::builder().set_dictionary_enabled(false).build();
    let schema = Arc::new(schema.expect("a schema"));
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, properties.into()).expect("a writer");
    let mut group = writer.next_row_group().expect("a group");
    for c in 0..=CHANNELS {
        let value = |k: usize| if c == 0 { k as f64 * 1e-3 } else { channel(k, c) };
        let values: Vec<f64> = (0..ROWS).map(value).collect();
        let mut column = group.next_column().expect("sound").expect("a column");
        column.typed::<DoubleType>().write_batch(&values, None, None).expect("written");
        column.close().expect("closed");
    }
    group.close().expect("closed");
    writer.into_inner().expect("written")
}

fn mcap_log() -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().compression(Some(mcap::Compression::Lz4));
    let mut writer = options.create(&mut bytes).expect("a writer");
    let definition = b"float64[] position";
    let schema = writer.add_schema("demo/msg/State", "ros2msg", definition).expect("a schema");
    let states = writer.add_channel(schema, "/state", "cdr", &BTreeMap::new()).expect("a channel");
    for k in 0..ROWS {
        let log_time = k as u64 * 1_000_000;
        let header = mcap::records::MessageHeader {
            channel_id: states,
            sequence: k as u32,
            log_time,
            publish_time: log_time,
        };
        let mut message = vec![0, 1, 0, 0];
        message.extend((CHANNELS as u32).to_le_bytes());
        message.extend([0; 4]);
        (0..CHANNELS).for_each(|c| message.extend(channel(k, c).to_le_bytes()));
        writer.write_to_known_channel(&header, &message).expect("written");
    }
    writer.finish().expect("finished");
    drop(writer);
    bytes.into_inner()
}

/// A number of a file of the system, in the line that begins so.
fn told(file: &str, begins: &str) -> u64 {
    let text = fs::read_to_string(file).expect("it is Linux");
    let line = text.lines().find_map(|line| line.strip_prefix(begins)).expect("its line");
    line.split_whitespace().next().and_then(|word| word.parse().ok()).expect("a number")
}

fn assert_bounded(folder: &Path, name: &str, bytes: &[u8]) {
    let file = folder.join(name);
    fs::write(&file, bytes).expect("written");
    // The largest memory counts from now.
    fs::write("/proc/self/clear_refs", "5").expect("reset");
    let before = (1024 * told("/proc/self/status", "VmRSS:"), told("/proc/self/io", "rchar:"));
    let runs = feeler_logs::read_file(&file, None).unwrap_or_else(|error| panic!("{error}"));
    let memory = (1024 * told("/proc/self/status", "VmHWM:")).saturating_sub(before.0);
    let read = told("/proc/self/io", "rchar:") - before.1;
    let table = &runs[0].tables[0];
    assert_eq!((table.rows(), table.columns.len()), (ROWS, CHANNELS), "{name}");
    let most = MOST_MEMORY * NUMBERS as f64 + BUFFERS as f64;
    assert!(memory as f64 <= most, "{name}: {memory} bytes of memory, more than {most}");
    // Less is a count that does not work.
    assert!(memory as f64 > 0.5 * NUMBERS as f64, "{name}: {memory} bytes of memory");
    let most = MOST_READ * bytes.len() as f64 + f64::from(1 << 20);
    assert!(read as f64 <= most && read >= bytes.len() as u64, "{name}: read {read}, {}", bytes.len());
}

/// A log of one format.
type Written = fn() -> Vec<u8>;

#[test]
fn truth_a_long_log_is_read_once_and_held_once() {
    if !Path::new("/proc/self/clear_refs").exists() {
        let _ = writeln!(std::io::stderr(), "skipped: memory is counted on Linux alone");
        return;
    }
    let own = std::env::current_exe().expect("a program");
    let said = Command::new(own).args(["--exact", COUNTED, "--ignored"]).output().expect("it runs");
    let text = String::from_utf8_lossy(&said.stdout);
    assert!(said.status.success() && text.contains("1 passed"), "{text}");
}

/// The test that runs in a process of its own.
const COUNTED: &str = "bounds::prop_bytes_and_memory_of_this_process_are_bounded";

#[test]
#[ignore = "counts for a whole process: another test starts it in one of its own"]
fn prop_bytes_and_memory_of_this_process_are_bounded() {
    let folder = tempfile::tempdir().expect("a folder");
    let kinds: [(&str, Written); 3] = [("a.csv", csv), ("a.parquet", parquet_table), ("a.mcap", mcap_log)];
    for (name, made) in kinds {
        assert_bounded(folder.path(), name, &made());
    }
}
