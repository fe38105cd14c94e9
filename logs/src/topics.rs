//! Topics of a bag, filled message by message and converted to tables.

use std::collections::HashMap;
use std::io::{self, Read as _};
use std::path::Path;

use indexmap::IndexMap;

use crate::clock::{Clock, ClockUnit};
use crate::error::{LogError, LogPlace};
use crate::json;
use crate::ros::{self, Decoder};
use crate::table::{Column, Run, Table};

/// Seconds per nanosecond.
const NANO: f64 = 1e-9;
/// Largest number of columns of one topic.
const MOST_COLUMNS: usize = 4096;
/// Stamps of a header and times of the log are on the same clock if they differ by less than this, s.
const SAME_CLOCK_S: f64 = 1.0;
/// Names that a message with a single number omits.
const PLAIN: [&str; 2] = ["value", "data"];
/// The remedy for a bag without definitions.
const CONVERT: &str = "`ros2 bag convert` of ROS 2 Iron or later adds it";
/// First bytes of a message that the recorder compressed by itself. No CDR and no JSON begins like this.
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];
/// Largest message, bytes. A sound message is far smaller.
const LARGEST: u64 = 1 << 28;
/// Path of a header's time, which is the clock and not a column.
const STAMP: &str = "header.stamp.";

/// The encoding of a topic's messages.
enum Form {
    Json,
    Ros(Box<Decoder>),
    /// Not decoded, for this reason.
    LeftOut(String),
}

struct Topic {
    name: String,
    form: Form,
    /// The type, if the bag does not define it and the usual definition is assumed.
    supposed: Option<String>,
    /// Definitions of earlier releases, for a first message that the present one does not fit.
    earlier: Vec<Decoder>,
    log_ns: Vec<i64>,
    stamps_ns: Vec<i64>,
    columns: Vec<Column>,
    by_path: HashMap<String, usize>,
    /// For each number of a message, the index of its column.
    slots: Vec<Option<usize>>,
    notes: Vec<String>,
    messages: usize,
}

/// All topics, by the number that the bag assigns.
#[derive(Default)]
pub(crate) struct Topics {
    topics: IndexMap<u64, Topic>,
}

/// The declaration of a topic in a bag.
pub(crate) struct Declared<'a> {
    pub(crate) name: &'a str,
    /// `json` or `cdr`.
    pub(crate) encoding: &'a str,
    pub(crate) schema_name: &'a str,
    pub(crate) schema_encoding: &'a str,
    /// `None` if the bag has no definition.
    pub(crate) schema: Option<&'a str>,
}

impl Topics {
    pub(crate) fn has(&self, id: u64) -> bool {
        self.topics.contains_key(&id)
    }

    pub(crate) fn declare(&mut self, id: u64, declared: &Declared<'_>) {
        let (form, earlier) = forms(declared);
        let topic = Topic {
            name: declared.name.into(),
            form,
            earlier,
            supposed: declared.schema.is_none().then(|| declared.schema_name.to_owned()),
            log_ns: Vec::new(),
            stamps_ns: Vec::new(),
            columns: Vec::new(),
            by_path: HashMap::new(),
            slots: Vec::new(),
            notes: Vec::new(),
            messages: 0,
        };
        self.topics.insert(id, topic);
    }

    /// Adds a message, which the recorder may have compressed by itself.
    pub(crate) fn push(&mut self, file: &Path, id: u64, log_ns: i64, sent: &[u8]) -> Result<(), LogError> {
        if !sent.starts_with(&ZSTD) {
            return self.push_plain(file, id, log_ns, sent);
        }
        let Some(topic) = self.topics.get(&id) else { return Ok(()) };
        let plain = unpack(sent).map_err(|error| {
            let place = LogPlace::Message { topic: topic.name.clone(), number: topic.messages, byte: 0 };
            let what = format!("its compression by zstd is damaged: {error}");
            LogError::damaged(file, place, what, "record it again")
        })?;
        self.push_plain(file, id, log_ns, &plain)
    }

    fn push_plain(&mut self, file: &Path, id: u64, log_ns: i64, message: &[u8]) -> Result<(), LogError> {
        let Some(topic) = self.topics.get_mut(&id) else { return Ok(()) };
        let number = topic.messages;
        topic.messages += 1;
        let fail = |name: &str, byte, what: String, remedy| {
            LogError::damaged(file, LogPlace::Message { topic: name.into(), number, byte }, what, remedy)
        };
        match &mut topic.form {
            Form::LeftOut(_) => {}
            Form::Json => {
                let numbers = json::numbers(message).map_err(|error| {
                    fail(
                        &topic.name,
                        error.column().saturating_sub(1),
                        error.to_string(),
                        "write each message as one JSON value",
                    )
                })?;
                let alone = numbers.len() == 1;
                topic.slots.clear();
                for (name, _) in &numbers {
                    let name = if alone && PLAIN.contains(&name.as_str()) { "" } else { name };
                    topic.slots.push(slot(&mut topic.columns, &mut topic.by_path, &topic.log_ns, name));
                }
                topic.log_ns.push(log_ns);
                let values: Vec<f64> = numbers.into_iter().map(|(_, value)| value).collect();
                fill(&mut topic.columns, &topic.slots, &values, topic.log_ns.len());
            }
            Form::Ros(decoder) => {
                let mut decoded = decoder.decode(message);
                let mut earlier = std::mem::take(&mut topic.earlier).into_iter();
                while decoded.is_err() && topic.log_ns.is_empty() {
                    let Some(next) = earlier.next() else { break };
                    **decoder = next;
                    decoded = decoder.decode(message);
                }
                let is_new = match (decoded, &topic.supposed) {
                    (Ok(is_new), _) => is_new,
                    // Types change from one release to the next.
                    (Err(_), Some(name)) if topic.log_ns.is_empty() => {
                        let why = format!(
                            "the bag holds no definition of {name}, and the usual ones do not fit \
                             ({CONVERT})"
                        );
                        topic.form = Form::LeftOut(why);
                        return Ok(());
                    }
                    (Err(error), _) => {
                        let remedy = "record it again, or convert the bag with `ros2 bag convert`";
                        return Err(fail(&topic.name, error.byte, error.what, remedy));
                    }
                };
                if is_new {
                    let alone = decoder.paths().len() == 1;
                    topic.slots.clear();
                    for path in decoder.paths() {
                        let path = if alone && PLAIN.contains(&path.as_str()) { "" } else { path };
                        let is_stamp = decoder.stamp_ns().is_some() && path.starts_with(STAMP);
                        let found = if is_stamp {
                            None
                        } else {
                            slot(&mut topic.columns, &mut topic.by_path, &topic.log_ns, path)
                        };
                        topic.slots.push(found);
                    }
                    for left_out in decoder.left_out() {
                        let note = format!("{}.{left_out} is left out", topic.name);
                        if !topic.notes.contains(&note) && topic.notes.len() < 8 {
                            topic.notes.push(note);
                        }
                    }
                }
                topic.log_ns.push(log_ns);
                topic.stamps_ns.extend(decoder.stamp_ns());
                fill(&mut topic.columns, &topic.slots, decoder.values(), topic.log_ns.len());
            }
        }
        Ok(())
    }

    /// The tables, with times relative to the first message.
    pub(crate) fn into_run(self, file: &Path, name: String) -> Run {
        let mut run = Run { name, ..Run::default() };
        let mut timed = Vec::new();
        for (_, mut topic) in self.topics {
            run.notes.append(&mut topic.notes);
            match topic.form {
                Form::LeftOut(why) if topic.messages > 0 => {
                    run.notes
                        .push(format!("{}: {} messages are left out: {why}", topic.name, topic.messages));
                }
                Form::LeftOut(_) => {}
                _ if topic.messages == 0 => {}
                _ => timed.push(sorted(topic)),
            }
        }
        let first = timed.iter().filter_map(|(_, times, _)| times.first()).min().copied().unwrap_or(0);
        for (topic, times, clock) in timed {
            let (column, why) = clock;
            let mut table = Table {
                name: topic.name,
                file: file.to_owned(),
                clock: Some(Clock {
                    column,
                    unit: ClockUnit::Nanoseconds,
                    origin_s: first as f64 * NANO,
                    why,
                }),
                times_s: times.iter().map(|t| t.saturating_sub(first) as f64 * NANO).collect(),
                rows_before: 0,
                columns: topic.columns,
            };
            table.shrink();
            run.tables.push(table);
        }
        run
    }
}

/// A message that was compressed by itself, as `ros2 bag record --compression-mode message` does.
fn unpack(message: &[u8]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    zstd::stream::read::Decoder::new(message)?.take(LARGEST).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The form of a topic's messages, and those of earlier releases if the bag does not define it.
fn forms(declared: &Declared<'_>) -> (Form, Vec<Decoder>) {
    let name = declared.schema_name;
    let of = |encoding: &str, text: &str| ros::definition(encoding, name, text).map(Decoder::new);
    let or_left_out = |decoder: Result<Decoder, ros::DefinitionError>| match decoder {
        Ok(decoder) => Form::Ros(Box::new(decoder)),
        Err(error) => Form::LeftOut(error.to_string()),
    };
    let form = match (declared.encoding, declared.schema) {
        ("json", _) => Form::Json,
        ("cdr", Some(text)) => or_left_out(of(declared.schema_encoding, text)),
        ("cdr", None) => {
            let known = ros::well_known(name);
            let mut decoders = known.iter().map(|text| of("ros2msg", text));
            match decoders.next() {
                Some(last) => return (or_left_out(last), decoders.filter_map(Result::ok).collect()),
                None => Form::LeftOut(format!("the bag holds no definition of {name} ({CONVERT})")),
            }
        }
        (other, _) => Form::LeftOut(format!("they are encoded as `{other}` (write JSON or CDR messages)")),
    };
    (form, Vec::new())
}

/// The column of a path, created if new; earlier rows have no value.
fn slot(
    columns: &mut Vec<Column>,
    by_path: &mut HashMap<String, usize>,
    rows: &[i64],
    path: &str,
) -> Option<usize> {
    if let Some(found) = by_path.get(path) {
        return Some(*found);
    }
    if columns.len() >= MOST_COLUMNS {
        return None;
    }
    let mut column = Column::new(path, columns.len() + 1);
    column.values = vec![f64::NAN; rows.len()];
    columns.push(column);
    by_path.insert(path.to_owned(), columns.len() - 1);
    Some(columns.len() - 1)
}

fn fill(columns: &mut [Column], slots: &[Option<usize>], values: &[f64], rows: usize) {
    for (slot, value) in slots.iter().zip(values) {
        let Some(column) = slot.and_then(|i| columns.get_mut(i)) else { continue };
        // If two numbers of a message have one path, the first one counts.
        if column.values.len() < rows {
            column.values.push(*value);
        }
    }
    for column in columns {
        column.values.resize(rows, f64::NAN);
    }
}

/// A topic with its rows in order of time, its times, and their source.
fn sorted(mut topic: Topic) -> (Topic, Vec<i64>, (String, String)) {
    let log = std::mem::take(&mut topic.log_ns);
    let stamps = std::mem::take(&mut topic.stamps_ns);
    let rises = |times: &[i64]| times.windows(2).all(|pair| pair[0] <= pair[1]);
    let offset = stamps.first().zip(log.first()).map(|(a, b)| (a.saturating_sub(*b)) as f64 * NANO);
    let has_stamps = stamps.len() == log.len()
        && stamps.iter().all(|t| *t > 0)
        && (stamps.len() < 2 || stamps.windows(2).any(|pair| pair[0] != pair[1]));
    let (mut times, clock) = match offset {
        Some(offset) if has_stamps && offset.abs() < SAME_CLOCK_S && rises(&stamps) => (
            stamps,
            (
                "header.stamp".to_owned(),
                "the time of the header, which agrees with that of the log".to_owned(),
            ),
        ),
        Some(offset) if has_stamps && offset.abs() >= SAME_CLOCK_S => {
            let why = format!("the header is on another clock, {offset:.3} s away");
            (log, ("log time".to_owned(), why))
        }
        _ => (log, ("log time".to_owned(), "when each message was recorded".to_owned())),
    };
    if !rises(&times) {
        let mut order: Vec<usize> = (0..times.len()).collect();
        order.sort_by_key(|i| times[*i]);
        times = order.iter().map(|i| times[*i]).collect();
        for column in &mut topic.columns {
            column.values = order.iter().map(|i| column.values[*i]).collect();
        }
    }
    (topic, times, clock)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message in little-endian CDR.
    struct Written(Vec<u8>);

    impl Written {
        fn aligned(&mut self, bytes: &[u8]) {
            while !(self.0.len() - 4).is_multiple_of(bytes.len()) {
                self.0.push(0);
            }
            self.0.extend(bytes);
        }

        fn text(&mut self, text: &str) {
            self.aligned(&(text.len() as u32 + 1).to_le_bytes());
            self.0.extend(text.bytes().chain([0]));
        }

        /// A point of a trajectory with one position and nothing else.
        fn point(&mut self, position: f64) {
            self.aligned(&1_u32.to_le_bytes());
            self.aligned(&position.to_le_bytes());
            for word in [0_u32; 5] {
                self.aligned(&word.to_le_bytes());
            }
        }
    }

    /// Foxy's state of a joint trajectory controller has three points, Humble's six and more behind them.
    #[test]
    fn truth_the_state_of_a_controller_is_read_from_bags_of_foxy_and_humble() {
        let name = "control_msgs/msg/JointTrajectoryControllerState";
        for (points, behind, first) in [(3, 0, "desired"), (6, 1 + 6 * 5, "reference")] {
            let declared = Declared {
                name: "/state",
                encoding: "cdr",
                schema_name: name,
                schema_encoding: "",
                schema: None,
            };
            let mut topics = Topics::default();
            topics.declare(1, &declared);
            for k in 0..3 {
                let mut message = Written(vec![0, 1, 0, 0]);
                message.aligned(&(7_u32 + k).to_le_bytes());
                message.aligned(&0_u32.to_le_bytes());
                message.text("base");
                message.aligned(&1_u32.to_le_bytes());
                message.text("elbow");
                (0..points).for_each(|i| message.point(f64::from(10 * k + i) + 0.5));
                (0..behind).for_each(|_| message.aligned(&0_u32.to_le_bytes()));
                topics.push(Path::new("bag"), 1, i64::from(7 + k) * 1_000_000_000, &message.0).unwrap();
            }
            let run = topics.into_run(Path::new("bag"), "bag".into());
            assert_eq!(run.notes, Vec::<String>::new());
            let (_, column) = run.find(&format!("{first}.positions[elbow]")).expect(first);
            assert_eq!(column.values, [0.5, 10.5, 20.5]);
            let (_, error) = run.find("error.positions[elbow]").expect("the error");
            assert_eq!(error.values, [2.5, 12.5, 22.5]);
        }
    }

    #[test]
    fn truth_messages_that_are_compressed_one_by_one_are_unpacked() {
        let of = |change: fn(Vec<u8>) -> Vec<u8>| {
            let declared = Declared {
                name: "/command",
                encoding: "cdr",
                schema_name: "std_msgs/msg/Float64",
                schema_encoding: "ros2msg",
                schema: Some("float64 data"),
            };
            let mut topics = Topics::default();
            topics.declare(1, &declared);
            let mut message = Written(vec![0, 1, 0, 0]);
            message.aligned(&0.1_f64.to_le_bytes());
            topics.push(Path::new("bag"), 1, 7, &change(message.0))?;
            Ok::<Run, LogError>(topics.into_run(Path::new("bag"), "bag".into()))
        };
        let plain = of(|message| message).unwrap();
        assert_eq!(plain.tables[0].columns[0].values, [0.1]);
        assert_eq!(of(|message| zstd::bulk::compress(&message, 1).unwrap()).unwrap(), plain);
        let cut = of(|message| zstd::bulk::compress(&message, 1).unwrap()[..9].to_vec()).unwrap_err();
        assert!(cut.to_string().contains("message 0 of /command, byte 0: its compression by zstd"), "{cut}");
    }
}
