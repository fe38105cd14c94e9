//! Data sets of LeRobot (versions 2 and 3): Parquet tables of episodes, and names in `meta/info.json`.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::clock::{Clock, ClockUnit};
use crate::error::{LogError, LogPlace};
use crate::table::{Run, Table};

const EPISODE: &str = "episode_index";
const FRAME: &str = "frame_index";

/// Whether a folder is a data set of LeRobot.
pub(crate) fn is_one(folder: &Path) -> bool {
    folder.join("meta/info.json").is_file()
}

/// Tables of episodes, in order.
pub(crate) fn files(folder: &Path) -> Result<Vec<PathBuf>, LogError> {
    let data = folder.join("data");
    let mut found = Vec::new();
    if !data.is_dir() {
        let what = "this is a LeRobot data set without its folder `data`";
        return Err(LogError::other(folder, what, "copy `data` beside `meta`: it holds the tables"));
    }
    for chunk in fs::read_dir(&data).map_err(LogError::open(&data))?.filter_map(Result::ok) {
        let chunk = chunk.path();
        if !chunk.is_dir() {
            continue;
        }
        let entries = fs::read_dir(&chunk).map_err(LogError::open(&chunk))?;
        let files = entries.filter_map(Result::ok).map(|entry| entry.path());
        found.extend(files.filter(|path| path.extension().is_some_and(|ending| ending == "parquet")));
    }
    found.sort();
    Ok(found)
}

/// The data set of a table.
pub(crate) fn folder_of(file: &Path) -> Option<PathBuf> {
    file.ancestors().skip(1).take(4).find(|folder| is_one(folder)).map(Path::to_owned)
}

/// Divides a table into its episodes, and names the items of its lists.
pub(crate) fn episodes(run: Run, folder: &Path) -> Result<Vec<Run>, LogError> {
    let path = folder.join("meta/info.json");
    let bytes = fs::read(&path).map_err(LogError::open(&path))?;
    let info: Value = serde_json::from_slice(&bytes).map_err(|error| {
        LogError::damaged(&path, LogPlace::Row(error.line()), error.to_string(), "copy meta/info.json again")
    })?;
    let rate_hz = info.get("fps").and_then(Value::as_f64).filter(|rate| *rate > 0.0);
    let Some(mut table) = run.tables.into_iter().next() else { return Ok(Vec::new()) };
    for column in &mut table.columns {
        if let Some(name) = item_name(&info, &column.name) {
            column.name = name;
        }
    }
    let of = |name: &str| table.columns.iter().find(|column| column.name == name);
    let whole = [0.0].repeat(table.rows());
    let numbers = of(EPISODE).map_or(whole, |column| column.values.clone());
    let mut runs = Vec::new();
    let mut start = 0;
    for rows in numbers.chunk_by(|a, b| a.to_bits() == b.to_bits()) {
        let range = start..start + rows.len();
        start = range.end;
        let mut own = cut(&table, range);
        let frames = own.columns.iter().find(|column| column.name == FRAME);
        if let (Some(rate_hz), Some(frames)) = (rate_hz, frames) {
            own.times_s = frames.values.iter().map(|frame| frame / rate_hz).collect();
            let why = format!("frames at {rate_hz} Hz, as meta/info.json states");
            own.clock = Some(Clock { column: FRAME.into(), unit: ClockUnit::Seconds, origin_s: 0.0, why });
        }
        own.columns.retain(|column| !["index", FRAME, EPISODE, "task_index"].contains(&column.name.as_str()));
        own.name = String::new();
        let name = format!("episode-{}", rows.first().copied().unwrap_or(0.0));
        runs.push(Run { name, tables: vec![own], notes: run.notes.clone() });
    }
    Ok(runs)
}

fn cut(table: &Table, rows: std::ops::Range<usize>) -> Table {
    let mut own = Table { columns: Vec::new(), times_s: Vec::new(), ..table.clone() };
    own.times_s = table.times_s.get(rows.clone()).unwrap_or_default().to_vec();
    own.rows_before = table.rows_before + rows.start;
    own.columns.clone_from(&table.columns);
    for column in &mut own.columns {
        column.values = column.values.get(rows.clone()).unwrap_or_default().to_vec();
    }
    own
}

/// `action[2]` with the name of its item, as in `action[elbow_flex.pos]`.
fn item_name(info: &Value, column: &str) -> Option<String> {
    let (feature, rest) = column.split_once('[')?;
    let i: usize = rest.strip_suffix(']')?.parse().ok()?;
    let mut names = info.get("features")?.get(feature)?.get("names")?;
    // Older versions hold the list in a table of one entry, as in { "motors": [...] }.
    if let Some(only) = names.as_object().and_then(|table| table.values().next()) {
        names = only;
    }
    Some(format!("{feature}[{}]", names.get(i)?.as_str()?))
}
