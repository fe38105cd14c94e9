//! Faults of measured series: each with file, column, row and remedy; either fatal or a stated warning.

use std::fmt;

use feeler_plant::description::Engagement;
use feeler_scenarios::format::Experiment;

use super::{Dataset, Record, Table, file_name, role_is_check};

/// What is wrong with a series.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FaultKind {
    /// The file has no such column.
    MissingColumn,
    /// The dataset names no command of any drive.
    NoCommand,
    /// There are fewer rows than a prediction needs.
    TooShort {
        /// Rows there are.
        rows: usize,
    },
    /// A cell is empty or no number.
    NotANumber {
        /// How many such cells the column has.
        cells: usize,
    },
    /// The time stamp is not after the one before.
    TimeGoesBack,
    /// Rows are missing.
    Gap {
        /// Length, s.
        seconds: f64,
    },
    /// Rows are not evenly spaced.
    Uneven {
        /// Largest departure from the mean spacing, as a fraction of it.
        share: f64,
    },
    /// Rows are much further apart than commands are held.
    SlowRows {
        /// Spacing of the rows, s.
        spacing_s: f64,
        /// How long a command is held, s.
        hold_s: f64,
    },
    /// Every row has the same value.
    Constant,
    /// The command never changes: nothing is excited.
    ConstantCommand,
    /// The largest or smallest value repeats in many consecutive rows, as a converter at its end does.
    Clipped {
        /// The value.
        value: f64,
        /// Share of rows there.
        share: f64,
    },
    /// All values are multiples of a step coarser than believed.
    Quantised {
        /// The step, signal units.
        step: f64,
    },
    /// The series varies hardly more than its noise.
    WeakExcitation {
        /// Variation over noise.
        ratio: f64,
    },
    /// The series varies less than noise alone would: its noise or its unit is another than stated.
    BelowNoise {
        /// Variation over noise.
        ratio: f64,
    },
    /// Two channels of the same motion differ by a factor between units.
    Units {
        /// The other column.
        other: String,
        /// This one over the other.
        factor: f64,
        /// The factor in words.
        what: &'static str,
        /// How many experiments show it.
        experiments: usize,
    },
    /// Two channels that must move together do so with a shift in time.
    ClockOffset {
        /// The other column.
        other: String,
        /// By how much this one is late, s.
        late_s: f64,
        /// How many experiments show it.
        experiments: usize,
    },
    /// The experiment was to be fitted, as all others, so that none would have been left to score.
    SetAside,
}

impl FaultKind {
    /// Whether no stated assumption can repair it.
    pub fn is_fatal(&self) -> bool {
        matches!(
            self,
            Self::MissingColumn
                | Self::NoCommand
                | Self::TooShort { .. }
                | Self::NotANumber { .. }
                | Self::TimeGoesBack
                | Self::Gap { .. }
                | Self::ConstantCommand
                | Self::SlowRows { .. }
        )
    }

    /// Whether the records contradict each other, so that a diagnosis of them may find the fault in place of a cause.
    pub fn is_contradiction(&self) -> bool {
        matches!(self, Self::Units { .. } | Self::ClockOffset { .. } | Self::BelowNoise { .. })
    }

    fn message_and_remedy(&self) -> (String, &'static str) {
        match self {
            Self::MissingColumn => ("the column is missing".into(), "record it, or take it out of [columns]"),
            Self::NoCommand => (
                "no column is the command of a drive".into(),
                "add one with `signal = \"<actuator>.command\"`: without it nothing drives the prediction",
            ),
            Self::TooShort { rows } => (format!("only {rows} rows"), "record at least 50 rows"),
            Self::NotANumber { cells } => {
                (format!("no number here ({cells} such cells in the column)"), "cut the file there, or record again")
            }
            Self::TimeGoesBack => ("the time stamp does not advance".into(), "sort the rows, or repair the clock of the recorder"),
            Self::Gap { seconds } => (format!("{seconds:.4} s are missing before this row"), "split the file here into two experiments"),
            Self::Uneven { share } => (
                format!("rows depart from even spacing by up to {:.0} %", 100.0 * share),
                "series were brought to an even grid by interpolation",
            ),
            Self::SlowRows { spacing_s, hold_s } => (
                format!("rows are {spacing_s:.4} s apart, though a command is held for {hold_s} s"),
                "bring the time to seconds, or record every command",
            ),
            Self::Constant => ("the value never changes".into(), "the column is left out of this experiment's score; check the wiring"),
            Self::ConstantCommand => ("the command never changes".into(), "excite the drive, or take the experiment out"),
            Self::Clipped { value, share } => {
                (format!("{:.1} % of rows sit at {value}", 100.0 * share), "these rows do not count; widen the range of the channel")
            }
            Self::Quantised { step } => {
                (format!("values are multiples of {step:.4e}, coarser than believed"), "taken as a finding, not as noise")
            }
            Self::WeakExcitation { ratio } => {
                (format!("the series varies only {ratio:.1} times its noise"), "it can tell little; excite more strongly")
            }
            Self::BelowNoise { ratio } => (
                format!("the series varies only {ratio:.2} times its noise, less than noise alone would"),
                "check the unit of the column, and the `noise` that is stated",
            ),
            Self::Units { other, factor, what, experiments } => (
                format!("reads {} times what `{other}` says of the same motion, about {what}{}", short(*factor), as_in(*experiments)),
                "bring both columns to SI",
            ),
            Self::ClockOffset { other, late_s, experiments } => {
                let other = if other.contains(' ') { other.clone() } else { format!("`{other}`") };
                let side = if *late_s > 0.0 { "behind" } else { "ahead of" };
                (
                    format!("runs {:.3} ms {side} {other}{}", 1e3 * late_s.abs(), as_in(*experiments)),
                    "shift the column, or, where the sensor itself is late, set its `delay` in the machine file",
                )
            }
            Self::SetAside => (
                "every experiment is to be fitted, so that none would be left to score: this one is set aside".into(),
                "give one `role = \"check\"` to choose which",
            ),
        }
    }
}

/// Four digits of a factor of any size.
fn short(factor: f64) -> String {
    if (0.1..1e4).contains(&factor.abs()) { format!("{factor:.3}") } else { format!("{factor:.3e}") }
}

fn as_in(experiments: usize) -> String {
    match experiments {
        0 | 1 => String::new(),
        2 => ", as in another experiment".into(),
        n => format!(", as in {} other experiments", n - 1),
    }
}

/// One fault, with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The file.
    pub file: String,
    /// The column, where one is meant.
    pub column: Option<String>,
    /// The row in the file (the header is row 1), where one is meant.
    pub row: Option<usize>,
    /// What is wrong.
    pub kind: FaultKind,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (message, remedy) = self.kind.message_and_remedy();
        write!(f, "{}", self.file)?;
        if let Some(row) = self.row {
            write!(f, ":{row}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ": `{column}`")?;
        }
        write!(f, ": {message} ({remedy})")
    }
}

/// Rows that a prediction needs.
const FEWEST_ROWS: usize = 50;
/// A spacing this many times the median is a gap.
const GAP_FACTOR: f64 = 4.0;
/// Rows this many holds of a command apart are seconds that were taken for something else: what was commanded in between is unknown.
const MOST_HOLDS: f64 = 100.0;
/// Departure from even spacing, in fractions of it, above which series are interpolated.
const UNEVEN_SHARE: f64 = 0.01;
/// Consecutive rows at an extreme value that are taken for clipping.
const CLIPPED_RUN: usize = 8;
/// Variation over noise below which a series can tell little.
const WEAK_RATIO: f64 = 3.0;
/// The same below which not even the stated noise is in it.
const BELOW_NOISE: f64 = 0.8;
/// First row of data in a file with a header.
const FIRST_ROW: usize = 2;

/// Turns tables into records and gives every fault found on the way.
pub(super) fn assemble(dataset: &mut Dataset, experiments: &[Experiment], tables: Vec<Table>, holds: &[Option<f64>]) -> Vec<Fault> {
    let mut faults = Vec::new();
    let grains: Vec<f64> = dataset.channels.iter().map(|channel| grain(channel, &tables)).collect();
    if dataset.drives.is_empty() {
        faults.push(Fault { file: dataset.name.clone(), column: None, row: None, kind: FaultKind::NoCommand });
    }
    for (experiment, table) in experiments.iter().zip(tables) {
        let before = faults.len();
        let mut note = |column: Option<&str>, row: Option<usize>, kind| {
            faults.push(Fault { file: file_name(&table.file), column: column.map(str::to_owned), row, kind });
        };
        let names: Vec<&str> = (dataset.drives.iter().map(|(_, name)| name.as_str()))
            .chain(dataset.channels.iter().map(|channel| channel.column.as_str()))
            .collect();
        let mut columns = Vec::new();
        for name in &names {
            match table.header.iter().position(|header| header == name) {
                // A converter that writes -0 means 0.
                Some(i) => columns.push(table.columns[i].iter().map(|x| x + 0.0).collect::<Vec<f64>>()),
                None => note(Some(name), None, FaultKind::MissingColumn),
            }
        }
        let mut time = table.columns.first().cloned().unwrap_or_default();
        if time.len() < FEWEST_ROWS {
            note(None, None, FaultKind::TooShort { rows: time.len() });
            continue;
        }
        if columns.len() < names.len() {
            continue;
        }
        for (name, column) in std::iter::once((&table.header[0].as_str(), &time)).chain(names.iter().zip(&columns)) {
            if let Some(row) = column.iter().position(|x| !x.is_finite()) {
                let cells = column.iter().filter(|x| !x.is_finite()).count();
                note(Some(name), Some(row + FIRST_ROW), FaultKind::NotANumber { cells });
            }
        }
        time_faults(&time, &mut |row, kind| note(None, row, kind));
        let spacing_s = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
        if let Some(hold_s) = holds.iter().flatten().copied().find(|hold_s| spacing_s > MOST_HOLDS * hold_s) {
            note(None, None, FaultKind::SlowRows { spacing_s, hold_s });
        }
        let drives = dataset.drives.len();
        for (i, (name, column)) in names.iter().zip(&columns).enumerate() {
            // Noise and motion alike were rounded away: the step, which other experiments show, is the finding.
            if i >= drives && grains[i - drives] > 0.0 && range(column) <= 2.0 * grains[i - drives] {
                continue;
            }
            let constant = column.iter().all(|x| x.to_bits() == column[0].to_bits());
            if constant && i < drives {
                note(Some(name), None, FaultKind::ConstantCommand);
            } else if constant {
                note(Some(name), None, FaultKind::Constant);
            } else if i >= drives {
                let channel = &dataset.channels[i - drives];
                // A force out of contact is nothing but noise, and must be.
                let is_idle = experiment.engagement == Some(Engagement::Free) && channel.is_of_contact(&dataset.machine);
                series_faults(column, channel.noise, channel.resolution, &mut |row, kind| {
                    if !(is_idle && matches!(kind, FaultKind::WeakExcitation { .. })) {
                        note(Some(name), row, kind);
                    }
                });
            }
        }
        if faults[before..].iter().any(|fault| fault.kind.is_fatal()) {
            continue;
        }
        if faults[before..].iter().any(|fault| matches!(fault.kind, FaultKind::Uneven { .. })) {
            for (i, column) in columns.iter_mut().enumerate() {
                *column = regrid(&time, column, spacing_s, i < drives && holds[i].is_some());
            }
            let first = time[0];
            time.iter_mut().enumerate().for_each(|(k, t)| *t = first + k as f64 * spacing_s);
        }
        let series = columns.split_off(drives);
        dataset.records.push(Record {
            name: file_name(&experiment.file),
            engagement: experiment.engagement,
            is_check: role_is_check(experiment.role),
            repeat: experiment.repeat.clone(),
            start_s: time[0],
            times_s: time,
            spacing_s,
            commands: columns,
            series,
        });
    }
    faults
}

fn time_faults(time: &[f64], note: &mut impl FnMut(Option<usize>, FaultKind)) {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    if let Some(row) = steps.iter().position(|step| *step <= 0.0) {
        note(Some(row + 1 + FIRST_ROW), FaultKind::TimeGoesBack);
        return;
    }
    let ordered = steps.clone();
    steps.sort_by(f64::total_cmp);
    let median = steps[steps.len() / 2];
    if let Some(row) = ordered.iter().position(|step| *step > GAP_FACTOR * median) {
        note(Some(row + 1 + FIRST_ROW), FaultKind::Gap { seconds: ordered[row] - median });
    }
    let departures = ordered.iter().map(|step| (step / median - 1.0).abs()).enumerate();
    if let Some((row, share)) = departures.max_by(|a, b| a.1.total_cmp(&b.1))
        && share > UNEVEN_SHARE
        && share <= GAP_FACTOR - 1.0
    {
        note(Some(row + 1 + FIRST_ROW), FaultKind::Uneven { share });
    }
}

/// The coarsest step, beyond what is believed, that a channel shows in any experiment; 0 if none.
fn grain(channel: &super::Channel, tables: &[Table]) -> f64 {
    let steps = tables.iter().filter_map(|table| {
        let column = table.header.iter().position(|header| *header == channel.column)?;
        let values = &table.columns[column];
        let usable = values.len() >= FEWEST_ROWS && values.iter().all(|x| x.is_finite());
        usable.then(|| quantum(values).filter(|step| is_coarse(*step, channel.noise, channel.resolution)))?
    });
    steps.fold(0.0, f64::max)
}

fn is_coarse(step: f64, noise: f64, resolution: f64) -> bool {
    step > 1.5 * resolution && step > noise
}

fn range(column: &[f64]) -> f64 {
    let (low, high) = extremes(column);
    high - low
}

fn extremes(column: &[f64]) -> (f64, f64) {
    column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)))
}

fn series_faults(column: &[f64], noise: f64, resolution: f64, note: &mut impl FnMut(Option<usize>, FaultKind)) {
    let (low, high) = extremes(column);
    for extreme in [low, high] {
        let at = |x: f64| x.to_bits() == extreme.to_bits();
        let longest = column.chunk_by(|a, b| at(*a) == at(*b)).filter(|run| at(run[0])).map(<[f64]>::len).max().unwrap_or(0);
        // A coarse channel at rest repeats its extreme as well; a clipped one has left its noise behind on one side only.
        let share = column.iter().filter(|&&x| at(x)).count() as f64 / column.len() as f64;
        if longest >= CLIPPED_RUN && noise > 0.0 && resolution < noise && quantum(column).is_none() {
            let row = column.iter().position(|&x| at(x)).unwrap_or(0);
            note(Some(row + FIRST_ROW), FaultKind::Clipped { value: extreme, share });
        }
    }
    if let Some(step) = quantum(column)
        && is_coarse(step, noise, resolution)
    {
        note(None, FaultKind::Quantised { step });
    }
    let mean = column.iter().sum::<f64>() / column.len() as f64;
    let spread = (column.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / column.len() as f64).sqrt();
    let ratio = spread / noise;
    if noise > 0.0 && ratio < BELOW_NOISE {
        note(None, FaultKind::BelowNoise { ratio });
    } else if noise > 0.0 && ratio < WEAK_RATIO {
        note(None, FaultKind::WeakExcitation { ratio });
    }
}

/// The step of which all values are multiples, if there are few enough different values for it to show: the smallest distance of different
/// values, refined over all of them.
pub(crate) fn quantum(column: &[f64]) -> Option<f64> {
    let mut values = column.to_vec();
    values.sort_by(f64::total_cmp);
    let range = values[values.len() - 1] - values[0];
    let rounding = 1e-6 * range.max(f64::MIN_POSITIVE);
    values.dedup_by(|b, a| (*b - *a).abs() <= rounding);
    // As many different values as a third of the rows: no step shows.
    if values.len() < 4 || values.len() > column.len() / 3 {
        return None;
    }
    let mut gaps: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_by(f64::total_cmp);
    let mut step = gaps[gaps.len() / 4];
    if step <= 0.0 {
        return None;
    }
    // Refined by least squares on ever longer distances: an early error of the step would otherwise miscount them.
    let first = values[0];
    for reach in [4.0, 16.0, 64.0, 256.0, 1024.0, 4096.0] {
        let (mut xx, mut xy) = (0.0, 0.0);
        for value in &values {
            let n = ((value - first) / step).round();
            if n.abs() <= reach {
                xx += n * n;
                xy += n * (value - first);
            }
        }
        if xx > 0.0 {
            step = xy / xx;
        }
    }
    let off = |x: f64| {
        let n = x / step;
        (n - n.round()).abs()
    };
    let worst = values.iter().map(|x| off(x - first)).fold(0.0, f64::max);
    (worst < 0.1).then_some(step)
}

fn regrid(time: &[f64], column: &[f64], spacing_s: f64, held: bool) -> Vec<f64> {
    let mut at = 0;
    (0..time.len())
        .map(|i| {
            let t = time[0] + i as f64 * spacing_s;
            while at + 2 < time.len() && time[at + 1] <= t {
                at += 1;
            }
            let share = ((t - time[at]) / (time[at + 1] - time[at])).clamp(0.0, 1.0);
            if held { column[at] } else { column[at] + share * (column[at + 1] - column[at]) }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_quantised_sine_shows_its_step() {
        let step = 0.037;
        let column: Vec<f64> = (0..4000).map(|k| ((f64::from(k) * 0.01).sin() / step).round() * step).collect();
        let found = quantum(&column).unwrap();
        // Least squares over levels that are multiples to rounding.
        assert!((found / step - 1.0).abs() < 1e-9);
        let smooth: Vec<f64> = (0..4000).map(|k| (f64::from(k) * 0.01).sin()).collect();
        assert_eq!(quantum(&smooth), None);
    }

    #[test]
    fn truth_time_that_goes_back_and_gaps_are_placed() {
        let mut faults = Vec::new();
        time_faults(&[0.0, 0.1, 0.2, 0.15, 0.4], &mut |row, kind| faults.push((row, kind)));
        assert_eq!(faults, [(Some(5), FaultKind::TimeGoesBack)]);
        faults.clear();
        time_faults(&[0.0, 0.1, 0.2, 0.3, 0.4, 1.4, 1.5], &mut |row, kind| faults.push((row, kind)));
        assert!(matches!(faults.as_slice(), [(Some(7), FaultKind::Gap { seconds })] if (seconds - 0.9).abs() < 1e-12));
    }
}
