//! Other formats give the same dataset as CSV.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use feeler_diagnosis::dataset::Dataset;

use super::{HEADER, csv, folder, sound};

/// Time stamps of logs are integer nanoseconds, and values are written as text. Both have errors far below
/// this.
const SAME: f64 = 1e-9;

fn assert_same(other: &Path) {
    let reference = folder(&[("a.csv", csv(&sound()).as_bytes()), ("b.csv", csv(&sound()).as_bytes())]);
    let [reference, read] = [reference.path(), other].map(|path| Dataset::load(path).expect("sound records"));
    let (a, b) = (&reference.records[0], &read.records[0]);
    assert_eq!(a.len(), b.len());
    assert!((a.spacing_s - b.spacing_s).abs() < SAME);
    for (a, b) in a.commands.iter().chain(&a.series).zip(b.commands.iter().chain(&b.series)) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME * a.abs()));
    }
}

#[test]
fn truth_mcap_logs_say_the_same_as_csv() {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().compression(None).create(&mut bytes).unwrap();
    let channel = |writer: &mut mcap::Writer<_>, topic: &str| {
        writer.add_channel(0, topic, "json", &BTreeMap::new()).unwrap()
    };
    let ids = [
        channel(&mut writer, "/command_n"),
        channel(&mut writer, "encoder_m"),
        channel(&mut writer, "acceleration_mps2"),
    ];
    for (k, row) in sound().iter().enumerate() {
        let log_time = 5_000_000_000 + k as u64 * 1_000_000;
        for (i, text) in [
            format!("{{\"value\": {:?}}}", row[1]),
            format!("{:?}", row[2]),
            format!("{{\"data\": {:?}}}", row[3]),
        ]
        .iter()
        .enumerate()
        {
            let header = mcap::records::MessageHeader {
                channel_id: ids[i],
                sequence: k as u32,
                log_time,
                publish_time: log_time,
            };
            writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    let folder = folder(&[("a.mcap", bytes.get_ref()), ("b.csv", csv(&sound()).as_bytes())]);
    assert_same(folder.path());
}

#[test]
fn truth_parquet_tables_say_the_same_as_csv() {
    use parquet::data_type::DoubleType;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;

    let fields = HEADER.map(|name| format!("required double {name};")).concat();
    let schema = std::sync::Arc::new(parse_message_type(&format!("message rows {{{fields}}}")).unwrap());
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, std::sync::Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for i in 0..HEADER.len() {
        let mut column = group.next_column().unwrap().unwrap();
        let values: Vec<f64> = sound().iter().map(|row| row[i]).collect();
        column.typed::<DoubleType>().write_batch(&values, None, None).unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    let folder = folder(&[("a.parquet", &bytes), ("b.csv", csv(&sound()).as_bytes())]);
    assert_same(folder.path());
}

/// Columns in another order, separated by semicolons, with decimal commas, and the time in milliseconds.
#[test]
fn truth_tables_of_any_shape_say_the_same() {
    let columns = |order: [usize; 4], scale: f64| {
        let name = |i: usize| if i == 0 && scale > 1.0 { "time_ms" } else { HEADER[i] };
        let mut text = order.map(name).join(";") + "\n";
        for row in &sound() {
            let cell = |i: usize| (row[i] * if i == 0 { scale } else { 1.0 }).to_string().replace('.', ",");
            let _ = writeln!(text, "{}", order.map(cell).join(";"));
        }
        text
    };
    for (order, scale) in [([0, 1, 2, 3], 1.0), ([2, 0, 3, 1], 1.0), ([0, 1, 2, 3], 1e3)] {
        let folder =
            folder(&[("a.csv", columns(order, scale).as_bytes()), ("b.csv", csv(&sound()).as_bytes())]);
        let dataset = Dataset::load(folder.path()).expect("it is loaded");
        let [a, b] = [&dataset.records[0], &dataset.records[1]];
        assert_eq!((&a.commands, &a.series), (&b.commands, &b.series), "{order:?}");
        // Milliseconds have other rounding errors.
        assert!((a.spacing_s - b.spacing_s).abs() < 1e-12, "{order:?}");
    }
}
