//! References of controllers.

use std::path::Path;

use feeler_catalogue::{Content, Contents, Keyed};
use feeler_control::ReferenceSpec;
use feeler_control::reference::{FOLLOWED, SAMPLES_FILE, SAMPLES_PATH};

use super::{Builder, Item};
use crate::file::read_bytes;
use crate::read::join;
use crate::source::Origin;
use crate::tree::node_at;

/// Largest number of samples of a reference file.
const MOST_SAMPLES: usize = 20_000_000;
/// Largest size of a reference file in bytes: 50 for each sample.
const LARGEST_SAMPLES: u64 = 50 * MOST_SAMPLES as u64;

impl Builder<'_> {
    pub(super) fn reference(&mut self, item: Item<'_>, fields: &Contents) -> Option<ReferenceSpec> {
        match fields.get(FOLLOWED.name)? {
            Content::Table(table) if table.variant == Some(SAMPLES_FILE.name) => self.samples(item, table),
            content => ReferenceSpec::of_content(content),
        }
    }

    fn samples(&mut self, item: Item<'_>, table: &Contents) -> Option<ReferenceSpec> {
        let name: String = table.value(&SAMPLES_PATH)?;
        let origin = file_origin(item);
        let path = self.draft.sources.0[origin.source].directory.join(name);
        match read_samples(&path) {
            Ok((times_s, values)) => {
                let mut spec = ReferenceSpec::samples(times_s, values);
                spec.take(table);
                Some(spec)
            }
            Err(message) => {
                let remedy = "name a CSV file with the header `t_s,value`, relative to this file";
                self.problems.add(
                    &origin,
                    item.key(&join(FOLLOWED.name, SAMPLES_PATH.name)),
                    format!("{}: {message}", path.display()),
                    remedy,
                );
                None
            }
        }
    }
}

/// Place of the file's name; relative names refer to that file.
fn file_origin(item: Item<'_>) -> Origin {
    let named = node_at(item.table, &[FOLLOWED.name, SAMPLES_PATH.name]);
    named.map_or_else(|| item.at.clone(), |node| node.origin.clone())
}

/// Times and values of a CSV file; otherwise a message.
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
