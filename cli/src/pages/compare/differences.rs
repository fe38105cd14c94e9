//! Differences between scenarios and between datasets, for tables and for programs.

use feeler_diagnosis::dataset::Dataset;
use feeler_files::rounded;
use feeler_studies::run::Summary;
use indexmap::IndexMap;
use serde::Serialize;

use crate::numbers::{percent, with_unit};
use crate::pages::compare::taken::{LoopFigures, Taken};
use crate::units::Units;

/// Number of characters above which a number is shortened, and its number of digits then.
const LONG: usize = 10;
const DIGITS: usize = 7;
/// Differences below this share of a series' variation are rounding errors.
const ROUNDING: f64 = 1e-12;

/// Compared scenarios. The book shows the comments.
#[derive(Serialize)]
pub(crate) struct ComparedScenarios<'a> {
    /// The scenarios, in the order of the command.
    scenarios: Vec<ComparedScenario<'a>>,
    /// The keys that differ.
    differing: Vec<DifferingKey>,
}

/// A scenario with its results.
#[derive(Serialize)]
struct ComparedScenario<'a> {
    /// The file or folder as named on the command line, or the setting of a variant.
    name: &'a str,
    /// Summary of the run; `None` if the scenario cannot run.
    run: Option<&'a Summary>,
    /// Figures by linear theory; `None` if the scenario cannot be linearised.
    theory: Option<LoopFigures>,
}

/// A key that differs.
#[derive(Serialize)]
pub(super) struct DifferingKey {
    /// Dotted path of the key.
    key: String,
    /// SI unit of the number; empty if it has none.
    unit: String,
    /// Value of the key in each scenario, as TOML; `None` for a scenario without it.
    values: Vec<Option<String>>,
}

/// Compared datasets. The book shows the comments.
#[derive(Serialize)]
pub(crate) struct ComparedDatasets<'a> {
    /// Names of the datasets, in the order of the command.
    datasets: Vec<&'a str>,
    /// Each common column of the first dataset and another one.
    columns: Vec<ColumnDifference<'a>>,
}

/// Difference between a column of the first dataset and that of another one.
#[derive(Serialize)]
struct ColumnDifference<'a> {
    /// Name of the record.
    record: &'a str,
    /// Name of the other dataset.
    against: &'a str,
    /// Name of the column.
    column: &'a str,
    /// Unit of `variation` and `difference`.
    unit: &'static str,
    /// Root mean square of the column without its mean.
    variation: f64,
    /// Root mean square of the difference; zero if it is a rounding error.
    difference: f64,
}

impl<'a> ComparedScenarios<'a> {
    pub(crate) fn new(taken: &'a [Taken]) -> Self {
        let scenarios = taken.iter().map(|one| ComparedScenario {
            name: &one.name,
            run: one.run().map(|run| &run.summary),
            theory: one.figures(),
        });
        Self { scenarios: scenarios.collect(), differing: differing_keys(taken) }
    }
}

impl<'a> ComparedDatasets<'a> {
    pub(crate) fn new(sets: &'a [Dataset]) -> Self {
        let datasets = sets.iter().map(|set| set.name.as_str()).collect();
        let Some((first, others)) = sets.split_first() else { return Self { datasets, columns: Vec::new() } };
        let mut columns = Vec::new();
        for r in 0..first.records.len() {
            for other in others {
                columns
                    .extend((0..first.channels.len()).filter_map(|c| column_difference(first, other, r, c)));
            }
        }
        Self { datasets, columns }
    }

    /// A row for each column, the last cell with the difference as a share of the variation.
    pub(crate) fn rows(&self) -> Vec<Vec<String>> {
        let row = |found: &ColumnDifference| {
            let share = match found.variation {
                varies if varies > 0.0 => format!("{} %", percent(found.difference / varies)),
                _ => "-".into(),
            };
            vec![
                found.record.to_owned(),
                found.against.to_owned(),
                found.column.to_owned(),
                with_unit(found.variation, found.unit),
                with_unit(found.difference, found.unit),
                share,
            ]
        };
        self.columns.iter().map(row).collect()
    }
}

/// Difference between column `c` of record `r` and that of another dataset; `None` if that one has no such
/// column.
fn column_difference<'a>(
    first: &'a Dataset,
    other: &'a Dataset,
    r: usize,
    c: usize,
) -> Option<ColumnDifference<'a>> {
    let (record, channel) = (&first.records[r], &first.channels[c]);
    let same = other.records.iter().find(|own| own.name == record.name)?;
    let column = other.channels.iter().position(|own| own.column == channel.column)?;
    let since = |times: &[f64]| times.iter().map(|t| t - times[0]).collect::<Vec<f64>>();
    let there = onto(&since(&same.times_s), &same.series[column], &since(&record.times_s));
    let both = record.series[c].iter().zip(&there).filter(|(_, there)| there.is_finite());
    let (own, apart): (Vec<f64>, Vec<f64>) = both.map(|(a, b)| (*a, a - b)).unzip();
    let count = own.len().max(1) as f64;
    let mean = own.iter().sum::<f64>() / count;
    let rms = |values: &mut dyn Iterator<Item = f64>| {
        (values.map(|value| value * value).sum::<f64>() / count).sqrt()
    };
    let variation = rms(&mut own.iter().map(|value| value - mean));
    // Interpolation causes rounding errors.
    let difference = Some(rms(&mut apart.iter().copied())).filter(|apart| *apart > ROUNDING * variation);
    Some(ColumnDifference {
        record: &record.name,
        against: &other.name,
        column: &channel.column,
        unit: Units::of(&first.machine).unit(channel.quantity(&first.machine)),
        variation,
        difference: difference.unwrap_or(0.0),
    })
}

fn differing_keys(taken: &[Taken]) -> Vec<DifferingKey> {
    let mut keys: IndexMap<String, DifferingKey> = IndexMap::new();
    for (i, one) in taken.iter().enumerate() {
        for (key, value) in one.document.keys() {
            let new = || {
                let unit = one.document.unit(&key);
                DifferingKey { key: key.clone(), unit, values: vec![None; taken.len()] }
            };
            keys.entry(key.clone()).or_insert_with(new).values[i] = Some(value);
        }
    }
    // A name has no effect on a machine's behaviour.
    let differs =
        |found: &DifferingKey| !matches!(found.key.as_str(), "name" | "about") && differs(&found.values);
    keys.into_values().filter(differs).collect()
}

fn differs(values: &[Option<String>]) -> bool {
    values.windows(2).any(|pair| pair[0] != pair[1])
}

/// The keys that differ, with their values.
pub(crate) fn differing(taken: &[Taken]) -> Vec<Vec<String>> {
    let row = |DifferingKey { key, unit, values }| {
        let brief: Vec<Option<String>> = values.iter().map(|value| value.as_deref().map(short)).collect();
        let shown = if differs(&brief) { brief } else { values };
        let shown = shown.into_iter().map(|value| value.unwrap_or_else(|| "not set".into()));
        let head = if unit.is_empty() { key } else { format!("{key} ({unit})") };
        std::iter::once(head).chain(shown).collect()
    };
    differing_keys(taken).into_iter().map(row).collect()
}

/// A value; a long number is shortened to [`DIGITS`].
fn short(value: &str) -> String {
    match value.parse::<f64>() {
        // In the form of TOML: 2.0, not 2.
        Ok(number) if value.len() > LONG => format!("{:?}", rounded(number, DIGITS)),
        _ => value.to_owned(),
    }
}

/// Values of a curve at other points; NaN outside it.
pub(super) fn onto(xs: &[f64], ys: &[f64], at: &[f64]) -> Vec<f64> {
    let value = |x: f64| {
        let j = xs.partition_point(|known| *known < x);
        if j >= xs.len() {
            return f64::NAN;
        }
        if j == 0 {
            return if xs[0] <= x { ys[0] } else { f64::NAN };
        }
        ys[j - 1] + (x - xs[j - 1]) / (xs[j] - xs[j - 1]) * (ys[j] - ys[j - 1])
    };
    at.iter().map(|&x| value(x)).collect()
}
