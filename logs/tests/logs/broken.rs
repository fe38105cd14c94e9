//! Truncated or modified files: each gives an error with a place, or the complete part.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use feeler_logs::{LogError, Run, read_file};
use proptest::prelude::*;

const CASES: u32 = 200;

/// A log of joint states in CDR and one of JSON numbers.
fn mcap_log(compression: Option<mcap::Compression>) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().compression(compression).chunk_size(Some(512));
    let mut writer = options.create(&mut bytes).expect("a writer");
    let definition = b"float64[] position\nstring[] name\nuint8 mode";
    let schema = writer.add_schema("demo/msg/State", "ros2msg", definition).expect("a schema");
    let states = writer.add_channel(schema, "/state", "cdr", &BTreeMap::new()).expect("a channel");
    let plain = writer.add_channel(0, "/x", "json", &BTreeMap::new()).expect("a channel");
    for k in 0..40_u32 {
        let log_time = u64::from(k) * 1_000_000;
        let header = |channel_id| mcap::records::MessageHeader {
            channel_id,
            sequence: k,
            log_time,
            publish_time: log_time,
        };
        let mut message = vec![0, 1, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0];
        message.extend(f64::from(k).to_le_bytes());
        message.extend(0.5_f64.to_le_bytes());
        message.extend([2, 0, 0, 0, 2, 0, 0, 0, b'a', 0, 0, 0, 2, 0, 0, 0, b'b', 0, 3]);
        writer.write_to_known_channel(&header(states), &message).expect("written");
        writer.write_to_known_channel(&header(plain), b"{\"data\": 1.5}").expect("written");
    }
    writer.finish().expect("finished");
    drop(writer);
    bytes.into_inner()
}

/// An array of numpy, as `numpy.save` writes it.
fn npy() -> Vec<u8> {
    let mut header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (60, 2), }".to_vec();
    header.resize(117, b' ');
    header.push(b'\n');
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(header);
    bytes.extend((0..120).flat_map(|k| f64::from(k).to_le_bytes()));
    bytes
}

fn parquet_table() -> Vec<u8> {
    use parquet::data_type::DoubleType;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;

    let schema =
        parse_message_type("message rows { required double t_s; optional double x; }").expect("a schema");
    let mut bytes = Vec::new();
    let mut writer =
        SerializedFileWriter::new(&mut bytes, std::sync::Arc::new(schema), std::sync::Arc::default())
            .expect("a writer");
    let mut group = writer.next_row_group().expect("a group");
    let values: Vec<f64> = (0..80).map(f64::from).collect();
    let mut column = group.next_column().expect("a column").expect("a column");
    column.typed::<DoubleType>().write_batch(&values, None, None).expect("written");
    column.close().expect("closed");
    let mut column = group.next_column().expect("a column").expect("a column");
    column.typed::<DoubleType>().write_batch(&values, Some(&[1; 80]), None).expect("written");
    column.close().expect("closed");
    group.close().expect("closed");
    writer.close().expect("closed");
    bytes
}

fn runs(name: &str, bytes: &[u8]) -> Result<Vec<Run>, LogError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("written");
    read_file(&path, None)
}

fn read(name: &str, bytes: &[u8]) -> Result<usize, LogError> {
    runs(name, bytes).map(|runs| runs.iter().flat_map(|run| &run.tables).map(feeler_logs::Table::rows).sum())
}

fn whole() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("plain.mcap", mcap_log(None)),
        ("lz4.mcap", mcap_log(Some(mcap::Compression::Lz4))),
        ("zstd.mcap", mcap_log(Some(mcap::Compression::Zstd))),
        ("a.npy", npy()),
        ("a.parquet", parquet_table()),
        ("a.csv", b"t_s,x\n0.0,1.5\n0.25,-2.5\n0.5,3e-3\n".to_vec()),
        ("bag.db3", include_bytes!("../bag.db3").to_vec()),
        // By numpy.savez_compressed: a clock, two columns and whole numbers, 12 rows.
        ("a.npz", include_bytes!("../arrays.npz").to_vec()),
    ]
}

/// Reads a data set of LeRobot of one file.
fn read_lerobot(info: &[u8], table: &[u8]) -> Result<usize, LogError> {
    let folder = tempfile::tempdir().expect("a folder");
    let [meta, data] = ["meta", "data/chunk-000"].map(|name| folder.path().join(name));
    for (folder, name, bytes) in [(meta, "info.json", info), (data, "file-000.parquet", table)] {
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join(name), bytes).expect("written");
    }
    read_file(folder.path(), None)
        .map(|runs| runs.iter().flat_map(|run| &run.tables).map(feeler_logs::Table::rows).sum())
}

const INFO: &[u8] = br#"{"fps": 50, "features": {"action": {"names": ["pan.pos"]}}}"#;

/// Whether an error names the file and a byte, row, message, array or column, or the kind of the file. A byte
/// may give a column of Parquet another compression: then the file is whole.
fn is_clear(error: &LogError, name: &str) -> bool {
    let said = error.to_string();
    let has_place = ["byte ", "row ", "first bytes", "this is", "it is", "its table", "its column"]
        .iter()
        .any(|p| said.contains(p));
    said.contains(name) && has_place && !feeler_problem::Remedy::remedy(error).is_empty()
}

#[test]
fn truth_whole_files_are_read() {
    for (name, bytes) in whole() {
        assert!(read(name, &bytes).is_ok_and(|rows| rows >= 3), "{name}: {:?}", read(name, &bytes));
    }
}

#[test]
fn truth_definitions_and_messages_that_do_not_agree_are_placed() {
    let log = mcap_log(None);
    let at = log.windows(9).position(|bytes| bytes == b"float64[]").expect("the definition");
    let mut other = log.clone();
    other[at..at + 9].copy_from_slice(b"float64  ");
    // The checksum of its chunk is wrong now.
    let error = read("a.mcap", &other).expect_err("refused");
    assert!(is_clear(&error, "a.mcap"), "{error}");
}

/// One byte of the name `zstd` of a chunk's compression.
#[test]
fn regress_a_compression_that_does_not_exist_is_placed() {
    let mut log = mcap_log(Some(mcap::Compression::Zstd));
    let at = log.windows(4).position(|bytes| bytes == b"zstd").expect("a compressed chunk");
    log[at] = 0;
    let error = read("a.mcap", &log).expect_err("refused");
    assert!(is_clear(&error, "a.mcap") && error.to_string().contains(r#""\0std""#), "{error}");
}

/// Row 3 of the file, in seconds and as calendar times; times of day with zones among commas are times too.
#[test]
fn regress_a_clock_without_a_time_is_refused_with_its_row() {
    for rows in [["0.00", "oops", "0.02"], ["12:00:00.00Z", "", "12:00:00.02Z"]] {
        let text = |times: [&str; 3]| {
            let of = |time: &str| format!("{time},0.10314,0.00008\n");
            format!("time,target,position\n{}", times.map(of).concat())
        };
        let error = read("a.csv", text(rows).as_bytes()).expect_err("refused");
        assert!(error.to_string().contains("row 3") && error.to_string().contains("`time`"), "{error}");
        assert!(read("a.csv", text([rows[0], rows[2], rows[2]]).as_bytes()).is_ok());
    }
}

#[test]
fn prop_files_that_are_cut_off_say_where() {
    for (name, bytes) in whole().into_iter().filter(|(name, _)| *name != "a.csv") {
        for share in 1..40 {
            let end = bytes.len() * share / 40;
            let error = read(name, &bytes[..end]).err();
            assert!(
                error.as_ref().is_some_and(|error| is_clear(error, name)),
                "{name} cut at {end}: {error:?}"
            );
        }
    }
}

#[test]
fn prop_data_sets_of_lerobot_that_are_cut_off_say_where() {
    let table = parquet_table();
    assert_eq!(read_lerobot(INFO, &table).expect("it is whole"), 80);
    for end in 0..INFO.len() {
        let error = read_lerobot(&INFO[..end], &table).err();
        assert!(error.as_ref().is_some_and(|error| is_clear(error, "info.json")), "{end}: {error:?}");
    }
    for share in 1..10 {
        let error = read_lerobot(INFO, &table[..table.len() * share / 10]).err();
        assert!(error.as_ref().is_some_and(|error| is_clear(error, "file-000.parquet")), "{error:?}");
    }
}

/// The first chunk begins at byte 4. Thrift writes that as 8, after the number of its field, and -5 as 9.
#[test]
fn regress_a_chunk_of_parquet_before_its_file_is_refused() {
    let table = parquet_table();
    let places = (1..table.len()).filter(|&at| table[at - 1..=at] == [0x26, 8]);
    let refused = places.filter(|&at| {
        let mut other = table.clone();
        other[at] = 9;
        read("a.parquet", &other).is_err_and(|error| is_clear(&error, "a.parquet"))
    });
    assert!(refused.count() > 0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn prop_changed_bytes_of_lerobot_end_with_a_clear_error_or_with_numbers(
        in_table: bool,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let (mut info, mut table) = (INFO.to_vec(), parquet_table());
        let (bytes, name) =
            if in_table { (&mut table, "file-000.parquet") } else { (&mut info, "info.json") };
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Err(error) = read_lerobot(&info, &table) {
            prop_assert!(is_clear(&error, name), "{}", error);
        }
    }

    #[test]
    fn prop_changed_bytes_end_with_a_clear_error_or_with_numbers(
        which in 0_usize..8,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let (name, mut bytes) = whole().swap_remove(which);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Err(error) = read(name, &bytes) {
            prop_assert!(is_clear(&error, name), "{}", error);
        }
    }

    #[test]
    fn prop_any_text_is_a_table_or_an_error(text in "[0-9a-z,;\\[\\]\"\n\t .-]{0,200}") {
        if let Err(error) = read("a.csv", text.as_bytes()) {
            prop_assert!(is_clear(&error, "a.csv"), "{}", error);
        }
    }
}

#[test]
fn truth_a_folder_without_logs_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let error = feeler_logs::sources(&[folder.path()]).expect_err("no log");
    assert!(error.to_string().contains("holds no log"), "{error}");
    // As `ros2 bag record --compression-mode file` leaves it.
    std::fs::write(folder.path().join("bag_0.db3.zstd"), [0x28, 0xb5, 0x2f, 0xfd]).expect("written");
    let error = feeler_logs::sources(&[folder.path()]).expect_err("packed");
    let remedy = feeler_problem::Remedy::remedy(&error).into_owned();
    assert!(error.to_string().contains("compressed by zstd") && remedy.contains("zstd -d"), "{error}");
    assert!(feeler_logs::sources(&[Path::new("no such file")]).is_err());
}

/// The bag of the tests, packed as a whole. Cut off in its only block, it has no sort.
#[test]
fn truth_a_packed_bag_is_read_as_the_bag_in_it() {
    let plain = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/bag.db3")).expect("the bag");
    let packed = zstd::bulk::compress(&plain, 3).expect("packed");
    let columns = |name: &str, bytes: &[u8]| {
        let found = runs(name, bytes).expect("read");
        let tables = found.into_iter().flat_map(|run| run.tables);
        // As text: an empty cell is not a number, and equal to none.
        tables.map(|table| format!("{:?}", (table.name, table.times_s, table.columns))).collect::<Vec<_>>()
    };
    let held = columns("bag_0.db3", &plain);
    assert!(!held.is_empty());
    for name in ["bag_0.db3.zstd", "bag_0.DB3.zst", "bag"] {
        assert_eq!(columns(name, &packed), held, "{name}");
    }
    for end in [packed.len() / 2, packed.len() - 1] {
        let error = read("bag_0.db3.zstd", &packed[..end]).expect_err("cut");
        assert!(is_clear(&error, "bag_0.db3.zstd"), "{error}");
    }
    let other = read("a.csv.zst", &zstd::bulk::compress(b"t_s,x\n0,1\n", 3).expect("packed"));
    let remedy = feeler_problem::Remedy::remedy(&other.expect_err("a table")).into_owned();
    assert!(remedy.contains("zstd -d"), "{remedy}");
}

/// An archive that unpacks without end: refused by what its header promises.
#[test]
fn truth_an_archive_that_unpacks_to_too_many_numbers_is_refused() {
    let archive = |rows: usize| {
        let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        writer.start_file("q.npy", zip::write::SimpleFileOptions::default()).expect("a file");
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows},), }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.resize(bytes.len() + 8 * rows.min(1 << 17), 0);
        std::io::Write::write_all(&mut writer, &bytes).expect("written");
        writer.finish().expect("an archive").into_inner()
    };
    // A megabyte of zeros is a log of a robot at rest.
    assert!(read("rest.npz", &archive(1 << 17)).is_ok());
    let error = read("bomb.npz", &archive(1 << 27)).expect_err("refused");
    assert!(is_clear(&error, "bomb.npz") && error.to_string().contains("too small"), "{error}");
}

/// Millions of equal numbers take a few bytes of a Parquet table.
#[test]
fn truth_a_parquet_table_of_endless_equal_numbers_is_refused() {
    use parquet::data_type::DoubleType;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    let table = |rows: usize, groups: usize| {
        let schema = parquet::schema::parser::parse_message_type("message a { required double x; }");
        let schema = std::sync::Arc::new(schema.expect("a schema"));
        let mut writer =
            SerializedFileWriter::new(Vec::new(), schema, WriterProperties::builder().build().into())
                .expect("a writer");
        let values = vec![1.0; rows];
        for _ in 0..groups {
            let mut group = writer.next_row_group().expect("a group");
            let mut column = group.next_column().expect("sound").expect("a column");
            column.typed::<DoubleType>().write_batch(&values, None, None).expect("written");
            column.close().expect("closed");
            group.close().expect("closed");
        }
        writer.into_inner().expect("written")
    };
    assert!(read("rest.parquet", &table(1 << 16, 1)).is_ok());
    let error = read("bomb.parquet", &table(1 << 20, 33)).expect_err("refused");
    assert!(is_clear(&error, "bomb.parquet") && error.to_string().contains("as no log does"), "{error}");
}
