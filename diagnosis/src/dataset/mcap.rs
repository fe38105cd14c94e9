//! MCAP logs (mcap.dev) with JSON messages.
//!
//! Every number in a message is a column: `topic.field`, with dots down nested objects, and the topic alone
//! for a message that is a number or whose only number is called `value` or `data`. A leading slash of a
//! topic is left out, others become dots. Time is the log time, from the first message of the file on. Rows
//! are those of the topic with the most messages; other topics are interpolated on them, held columns keep
//! their last value.

use std::path::Path;

use ::mcap::McapError;
use indexmap::IndexMap;
use serde_json::Value;

use super::Table;
use super::fault::NOT_THERE;
use crate::error::DiagnosisError;

/// Nanoseconds in a second.
const NANO: f64 = 1e-9;
/// Names of the one number of a message that need not be written.
const PLAIN: [&str; 2] = ["value", "data"];

/// Time stamps and values of one column.
#[derive(Default)]
struct Series {
    times_ns: Vec<u64>,
    values: Vec<f64>,
}

pub(super) fn table(path: &Path, held: &[&str]) -> Result<Table, DiagnosisError> {
    let damaged =
        "the log is damaged or cut off: `mcap recover` may save what is whole, else record it again";
    let fail = |reason: String, remedy| DiagnosisError::Unreadable { file: path.to_owned(), reason, remedy };
    let bytes = std::fs::read(path).map_err(|error| fail(error.to_string(), NOT_THERE))?;
    let mut columns: IndexMap<String, Series> = IndexMap::new();
    let mut other = None;
    for message in mcap::MessageStream::new(&bytes).map_err(|error| fail(error.to_string(), damaged))? {
        let message = message.map_err(|error| match error {
            McapError::UnsupportedCompression(with) => fail(
                format!("its chunks are compressed by {with}"),
                "write it with lz4 or without compression: `mcap compress --compression lz4` does so",
            ),
            other => fail(other.to_string(), damaged),
        })?;
        if message.channel.message_encoding != "json" {
            other = Some(message.channel.message_encoding.clone());
            continue;
        }
        let topic = message.channel.topic.trim_start_matches('/').replace('/', ".");
        let value: Value = serde_json::from_slice(&message.data).map_err(|error| {
            fail(format!("topic {topic}: {error}"), "write each message as one JSON value")
        })?;
        let mut numbers = Vec::new();
        flatten(&value, String::new(), &mut numbers);
        let alone = numbers.len() == 1;
        for (name, number) in numbers {
            let name = match name.as_str() {
                "" => topic.clone(),
                plain if alone && PLAIN.contains(&plain) => topic.clone(),
                name => format!("{topic}.{name}"),
            };
            let series = columns.entry(name).or_default();
            series.times_ns.push(message.log_time);
            series.values.push(number);
        }
    }
    let Some(longest) = columns.values().max_by_key(|series| series.values.len()) else {
        let what = other.map_or_else(
            || "no messages".to_owned(),
            |encoding| format!("only messages encoded as `{encoding}`"),
        );
        return Err(fail(
            format!("it has {what}"),
            "convert its channels to JSON messages, or the log to CSV or Parquet",
        ));
    };
    let start = columns.values().filter_map(|series| series.times_ns.first()).min().copied().unwrap_or(0);
    let grid = longest.times_ns.clone();
    let mut header = vec!["t_s".to_owned()];
    let mut values = vec![grid.iter().map(|t| (t - start) as f64 * NANO).collect::<Vec<f64>>()];
    for (name, series) in &columns {
        values.push(grid.iter().map(|&t| at(series, t, held.contains(&name.as_str()))).collect());
        header.push(name.clone());
    }
    Ok(Table { file: path.to_owned(), header, columns: values })
}

/// The numbers of a message with the way to each.
fn flatten(value: &Value, name: String, numbers: &mut Vec<(String, f64)>) {
    match value {
        Value::Number(number) => numbers.push((name, number.as_f64().unwrap_or(f64::NAN))),
        Value::Bool(flag) => numbers.push((name, f64::from(u8::from(*flag)))),
        Value::Object(fields) => {
            for (field, value) in fields {
                let name = if name.is_empty() { field.clone() } else { format!("{name}.{field}") };
                flatten(value, name, numbers);
            }
        }
        _ => {}
    }
}

/// A series at an instant: held, or on the line between its neighbours.
fn at(series: &Series, t: u64, held: bool) -> f64 {
    let after = series.times_ns.partition_point(|&time| time <= t);
    let Some(i) = after.checked_sub(1) else { return series.values[0] };
    let Some(&next) = series.times_ns.get(after).filter(|_| !held) else { return series.values[i] };
    let share = (t - series.times_ns[i]) as f64 / (next - series.times_ns[i]) as f64;
    series.values[i] + share * (series.values[after] - series.values[i])
}
