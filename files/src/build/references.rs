//! References of controllers.

use std::path::Path;

use feeler_catalogue::{Content, Contents};
use feeler_control::ReferenceSpec;
use feeler_control::reference::{Between, Lines, Sweep};

use super::{Builder, Item};
use crate::file::read_bytes;
use crate::source::Origin;

/// Most samples of a reference file.
const MOST_SAMPLES: usize = 20_000_000;
/// Bytes of the largest one: 50 for each sample.
const LARGEST_SAMPLES: u64 = 50 * MOST_SAMPLES as u64;

impl Builder<'_> {
    /// The reference of a controller.
    pub(super) fn reference(&mut self, item: Item<'_>, fields: &Contents) -> ReferenceSpec {
        let table = match fields.get("reference") {
            Some(Content::Number(value)) => return ReferenceSpec::Constant(*value),
            Some(Content::Points(points)) => return ReferenceSpec::Steps(points.clone()),
            Some(Content::Table(table)) => table,
            _ => return ReferenceSpec::Constant(0.0),
        };
        let offset = table.optional("offset").unwrap_or(0.0);
        let [low_hz, high_hz] = table.range("band").unwrap_or([0.0, 1.0]);
        match table.variant {
            Some("steps") => ReferenceSpec::Steps(table.points("points")),
            Some("ramp") => ReferenceSpec::PiecewiseLinear(table.points("points")),
            Some("chirp") => {
                let logarithmic = table.text("sweep") == Some("logarithmic");
                ReferenceSpec::Chirp {
                    sweep: if logarithmic { Sweep::Logarithmic } else { Sweep::Linear },
                    amplitude: table.number("amplitude"),
                    start_hz: table.number("start"),
                    end_hz: table.number("end"),
                    duration_s: table.number("duration"),
                    offset,
                }
            }
            Some("multisine") => {
                let lines = match table.text("lines") {
                    Some("odd") => Lines::Odd,
                    Some("odd-sparse") => Lines::OddSparse,
                    _ => Lines::All,
                };
                ReferenceSpec::Multisine {
                    lines,
                    low_hz,
                    high_hz,
                    period_s: table.number("period"),
                    rms: table.number("rms"),
                    offset,
                }
            }
            Some("white-noise") => {
                ReferenceSpec::WhiteNoise { low_hz, high_hz, rms: table.number("rms"), offset }
            }
            Some("prbs") => ReferenceSpec::Prbs {
                order: table.count("order").and_then(|order| u32::try_from(order).ok()).unwrap_or(2),
                clock_period_s: table.number("clock_period"),
                amplitude: table.number("amplitude"),
                offset,
            },
            Some("samples") => {
                let (times_s, values) = table.points("points").into_iter().unzip();
                ReferenceSpec::Table { times_s, values, between: between(table), offset }
            }
            Some("file") => self.samples(item, table, offset),
            _ => ReferenceSpec::Constant(table.number("value")),
        }
    }

    fn samples(&mut self, item: Item<'_>, table: &Contents, offset: f64) -> ReferenceSpec {
        let between = between(table);
        let mut spec = ReferenceSpec::Table { times_s: vec![0.0], values: vec![0.0], between, offset };
        let Some(name) = table.text("file") else { return spec };
        let origin = file_origin(item);
        let path = self.draft.sources.0[origin.source].directory.join(name);
        match read_samples(&path) {
            Ok((times, numbers)) => {
                spec = ReferenceSpec::Table { times_s: times, values: numbers, between, offset }
            }
            Err(message) => {
                let remedy = "name a CSV file with the header `t_s,value`, relative to this file";
                self.problems.add(
                    &origin,
                    item.key("reference.file"),
                    format!("{}: {message}", path.display()),
                    remedy,
                );
            }
        }
        spec
    }
}

fn between(table: &Contents) -> Between {
    if table.text("between") == Some("linear") { Between::Linear } else { Between::Hold }
}

/// Place of the file's name, against whose file it is relative.
fn file_origin(item: Item<'_>) -> Origin {
    let reference = item.table.get("reference").and_then(|entry| entry.node.as_table());
    reference
        .and_then(|table| table.get("file"))
        .map_or_else(|| item.at.clone(), |entry| entry.node.origin.clone())
}

/// Times and values of a CSV file; a message where it has none.
fn read_samples(path: &Path) -> Result<(Vec<f64>, Vec<f64>), String> {
    let bytes = read_bytes(path, LARGEST_SAMPLES).map_err(|error| error.to_string())?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes.as_slice());
    let headers = reader.headers().map_err(|error| error.to_string())?;
    if headers.iter().ne(["t_s", "value"]) {
        return Err(format!("its header is `{}`", headers.iter().collect::<Vec<_>>().join(",")));
    }
    let (mut times, mut values) = (Vec::new(), Vec::new());
    for (row, record) in reader.deserialize().enumerate() {
        let (time, value): (f64, f64) = record.map_err(|error| error.to_string())?;
        let line = row + 2;
        if !time.is_finite() || !value.is_finite() {
            return Err(format!("line {line}: {time}, {value} are not both finite"));
        }
        if times.last().is_some_and(|before| time <= *before) {
            return Err(format!("line {line}: the time {time} s does not increase"));
        }
        if row >= MOST_SAMPLES {
            return Err(format!("it has more than {MOST_SAMPLES} samples"));
        }
        times.push(time);
        values.push(value);
    }
    if times.is_empty() { Err("it has no samples".into()) } else { Ok((times, values)) }
}
