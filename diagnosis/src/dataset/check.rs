//! Detects faults of measured series, and converts sound series to records.

use std::path::Path;

use feeler_files::{Experiment, ExperimentRole};
use feeler_plant::description::{ActuatorKind, Engagement, Quantity};
use feeler_plant::names::nearest;

use super::bridge::{FIRST_LOST, Lost, empty_cells};
use super::data::{Channel, Dataset, Driven, FileRows, Record};
use super::fault::{Fault, FaultKind};
use super::quantum::{Grain, grain, quantum};
use super::regrid::{Between, far_from_rows, regrid};

/// Smallest number of rows for a prediction.
const FEWEST_ROWS: usize = 50;
/// A spacing of this many medians is a gap, if too many rows are missing for interpolation.
const GAP_FACTOR: f64 = 4.0;
/// If rows are this many command holds apart, the unit of time is wrong: the commands in between are unknown.
const MOST_HOLDS: f64 = 100.0;
/// If a command changes more often than once in this share of its hold, the hold is wrong.
const LEAST_HOLDS: f64 = 0.5;
/// Largest relative departure from even spacing without interpolation.
const UNEVEN_SHARE: f64 = 0.01;
/// Smallest number of rows at an extreme value, and of consecutive ones, that indicates clipping: noise
/// rarely repeats a value.
const CLIPPED_ROWS: usize = 8;
const CLIPPED_RUN: usize = 3;
/// A command that exceeds a limit by less than this share is at the limit: files round.
const ROUNDED: f64 = 1e-3;
/// Relative difference of spacings that counts as a fast or slow clock. Larger differences are other rates,
/// smaller ones are rounding.
const OTHER_CLOCK: std::ops::Range<f64> = 1e-3..0.1;
/// Smallest useful ratio of variation to noise.
const WEAK_RATIO: f64 = 3.0;
/// Below this ratio not even the stated noise is present.
const BELOW_NOISE: f64 = 0.8;

/// Converts tables to records, and returns all faults.
pub(super) fn assemble(
    dataset: &mut Dataset,
    experiments: &[Experiment],
    tables: Vec<FileRows>,
) -> Vec<Fault> {
    let mut faults = Vec::new();
    let grains: Vec<Grain> = dataset
        .channels
        .iter()
        .map(|channel| grain(|step| channel.is_coarse(step), readings(channel, &tables)))
        .collect();
    dataset.grains = grains.iter().map(|grain| grain.usual).collect();
    if dataset.drives.is_empty() {
        faults.push(Fault {
            file: dataset.name.clone(),
            column: None,
            row: None,
            kind: FaultKind::NoCommand,
        });
    }
    for (experiment, table) in experiments.iter().zip(tables) {
        let file = file_name(&table.file);
        let mut found = Vec::new();
        let mut note = |column: Option<&str>, row: Option<usize>, kind| {
            found.push(Fault { file: file.clone(), column: column.map(str::to_owned), row, kind });
        };
        let reader = Reader { dataset, experiment, grains: &grains };
        let sound = reader.series(&table, &mut note).filter(|_| !found.iter().any(|f| f.kind.is_fatal()));
        let is_uneven = found.iter().any(|fault| matches!(fault.kind, FaultKind::Uneven { .. }));
        let record = sound.map(|series| reader.record(series, is_uneven));
        dataset.records.extend(record);
        faults.append(&mut found);
    }
    other_clocks(dataset, &mut faults);
    resting_commands(dataset, &mut faults);
    copied_checks(dataset, &mut faults);
    faults
}

/// Records a fault with its column and row.
type Note<'a> = dyn FnMut(Option<&str>, Option<usize>, FaultKind) + 'a;

/// Contents of one experiment's file.
struct Series {
    times_s: Vec<f64>,
    /// Rows, including lost ones that were interpolated.
    rows: usize,
    spacing_s: f64,
    /// Commands, then channels.
    columns: Vec<Vec<f64>>,
    /// For each column, the rows without a reading; empty if there are none.
    bridged: Vec<Vec<bool>>,
    /// Channels that are ignored in this experiment.
    silent: Vec<bool>,
}

/// Reads the table of one experiment.
struct Reader<'a> {
    dataset: &'a Dataset,
    experiment: &'a Experiment,
    /// Quantisation steps of each channel.
    grains: &'a [Grain],
}

impl Reader<'_> {
    /// The series of a table; `None` if a recorded fault makes it useless.
    fn series(&self, table: &FileRows, note: &mut Note<'_>) -> Option<Series> {
        let names: Vec<&str> = (self.dataset.drives.iter().map(|driven| driven.column.as_str()))
            .chain(self.dataset.channels.iter().map(|channel| channel.column.as_str()))
            .collect();
        let (mut columns, mut bridged) = (Vec::new(), Vec::new());
        for name in &names {
            if let Some(i) = table.header.iter().position(|header| header == name) {
                // A converter that writes -0 means 0.
                columns.push(table.columns[i].iter().map(|x| x + 0.0).collect::<Vec<f64>>());
                bridged.push(table.bridged.get(i).cloned().unwrap_or_default());
            } else {
                let is_free = |header: &&String| !names.contains(&header.as_str());
                let known: Vec<String> = table.header.iter().skip(1).filter(is_free).cloned().collect();
                let within = known.iter().find(|header| header.contains(name)).map(String::as_str);
                let near = within.or_else(|| nearest(name, known.iter().map(String::as_str)));
                let near = near.map(str::to_owned);
                note(Some(name), None, FaultKind::MissingColumn { near, known });
                columns.push(Vec::new());
                bridged.push(Vec::new());
            }
        }
        let times_s = table.columns.first().cloned().unwrap_or_default();
        if times_s.len() < FEWEST_ROWS {
            note(None, None, FaultKind::TooShort { rows: times_s.len() });
            return None;
        }
        let is_complete = columns.iter().all(|column| !column.is_empty());
        for text in &table.notes {
            note(None, None, FaultKind::OtherRate { note: text.clone() });
        }
        let first_row = table.rows_before + 1;
        if let Some(row) = times_s.iter().position(|t| !t.is_finite()) {
            let cells = times_s.iter().filter(|t| !t.is_finite()).count();
            note(Some(&table.header[0]), Some(row + first_row), FaultKind::NotANumber { cells });
        }
        for (i, (name, column)) in names.iter().zip(&mut columns).enumerate() {
            let at = table.header.iter().position(|header| header == name);
            let unreadable = at.and_then(|at| table.unreadable[at]);
            let is_held = self.dataset.drives.get(i).is_some_and(|driven| driven.hold_s.is_some());
            if let Some((row, kind)) = empty_cells(column, &mut bridged[i], unreadable, is_held) {
                note(Some(name), Some(row + first_row), kind);
            }
        }
        time_faults(&times_s, first_row, &mut |row, kind| note(None, row, kind));
        let lost = Lost::bridged(&times_s).map_or(0, |lost| lost.rows);
        let rows = times_s.len() + lost;
        let spacing_s = (times_s[times_s.len() - 1] - times_s[0]) / (rows - 1) as f64;
        let holds = &mut self.dataset.drives.iter().filter_map(|driven| driven.hold_s);
        if let Some(hold_s) = holds.find(|hold_s| spacing_s > MOST_HOLDS * hold_s) {
            note(None, None, FaultKind::SlowRows { spacing_s, hold_s });
        }
        let advances = times_s.windows(2).all(|pair| pair[1] > pair[0]);
        for (driven, column) in self.dataset.drives.iter().zip(&columns).filter(|_| advances) {
            let changes = column.windows(2).filter(|pair| pair[0].to_bits() != pair[1].to_bits()).count();
            let every_s = rows as f64 * spacing_s / changes as f64;
            if let Some(hold_s) = driven.hold_s.filter(|hold_s| every_s < LEAST_HOLDS * hold_s) {
                note(Some(&driven.column), None, FaultKind::ShorterHold { every_s, hold_s });
            }
        }
        for (driven, column) in self.dataset.drives.iter().zip(&columns) {
            if let Some((row, kind)) = self.beyond_limit(driven, column) {
                note(Some(&driven.column), Some(row + first_row), kind);
            }
        }
        let silent = self.column_faults(&names, &columns, &bridged, first_row, note)?;
        // The faults of the other columns are still reported.
        if !is_complete {
            return None;
        }
        Some(Series { times_s, rows, spacing_s, columns, bridged, silent })
    }

    /// The first row of a force command beyond the limit of its drive.
    fn beyond_limit(&self, driven: &Driven, column: &[f64]) -> Option<(usize, FaultKind)> {
        let drive = &self.dataset.machine.actuators[driven.drive];
        let limit = drive.limit_n.filter(|_| matches!(drive.kind, ActuatorKind::Force { .. }))?;
        let is_beyond = |u: &&f64| u.abs() > (1.0 + ROUNDED) * limit;
        let first = column.iter().position(|u| is_beyond(&u))?;
        let rows = column.iter().filter(is_beyond).count();
        let largest = column.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
        Some((first, FaultKind::BeyondLimit { rows, largest, limit }))
    }

    /// Checks every column. Returns the channels that do not count; `None` if no channel measures the
    /// position of the machine.
    fn column_faults(
        &self,
        names: &[&str],
        columns: &[Vec<f64>],
        bridged: &[Vec<bool>],
        first_row: usize,
        note: &mut Note<'_>,
    ) -> Option<Vec<bool>> {
        let drives = self.dataset.drives.len();
        // One command may be constant while another moves the machine.
        if columns[..drives].iter().all(|column| !column.is_empty() && is_constant(column)) {
            for name in &names[..drives] {
                note(Some(name), None, FaultKind::ConstantCommand);
            }
        }
        let mut silent = vec![false; names.len() - drives];
        let mut is_lost = false;
        for (i, (name, column)) in names.iter().zip(columns).skip(drives).enumerate() {
            let rows = read_rows(column.len(), &bridged[drives + i]);
            let readings: Vec<f64> = rows.iter().map(|k| column[*k]).collect();
            // A missing column and cells without a number are already reported.
            if readings.is_empty() {
                silent[i] = true;
                continue;
            }
            let mut at_row = |name: Option<&str>, reading: Option<usize>, kind| {
                note(name, reading.map(|reading| first_row + rows[reading]), kind);
            };
            let (is_silent, loses_place) = self.channel_faults(i, name, &readings, &mut at_row);
            silent[i] = is_silent;
            is_lost |= loses_place;
        }
        (!is_lost).then_some(silent)
    }

    /// Checks the readings of one channel. Returns whether the channel is ignored, and whether the machine's
    /// position is then unknown.
    fn channel_faults(&self, i: usize, name: &str, column: &[f64], note: &mut Note<'_>) -> (bool, bool) {
        // Quantisation hides noise and motion. Other experiments show the step, which is reported instead.
        let grain = self.grains[i].coarsest;
        if grain > 0.0 && range(column) <= 2.0 * grain {
            return (false, false);
        }
        let channel = &self.dataset.channels[i];
        let tells_place = channel.quantity(&self.dataset.machine) == Quantity::Position;
        if is_constant(column) {
            // A wall may hold an encoder at a constant value.
            let is_held = tells_place && self.experiment.engagement == Some(Engagement::Clamped);
            let loses_place = tells_place && !is_held;
            note(Some(name), None, FaultKind::Constant { tells_place: loses_place });
            return (!is_held, loses_place);
        }
        // Without contact a force sensor must read pure noise.
        let is_idle = self.experiment.engagement == Some(Engagement::Free)
            && channel.is_of_contact(&self.dataset.machine);
        let mut is_clipped = false;
        series_faults(column, channel, tells_place, &mut |row, kind| {
            is_clipped |= matches!(kind, FaultKind::Clipped { .. });
            if !(is_idle && matches!(kind, FaultKind::WeakExcitation { .. })) {
                note(Some(name), row, kind);
            }
        });
        (is_clipped, is_clipped && tells_place)
    }

    /// The evenly spaced record of a sound series.
    fn record(&self, series: Series, is_uneven: bool) -> Record {
        let Series { mut times_s, rows, spacing_s, columns: mut commands, mut bridged, silent } = series;
        let drives = self.dataset.drives.len();
        if rows > times_s.len() || is_uneven {
            for (i, column) in commands.iter_mut().enumerate() {
                let between = match i.checked_sub(drives) {
                    Some(c)
                        if self.dataset.channels[c].quantity(&self.dataset.machine) == Quantity::Position =>
                    {
                        Between::Smooth
                    }
                    None if self.dataset.drives[i].hold_s.is_some() => Between::Held,
                    _ => Between::Straight,
                };
                *column = regrid(&times_s, column, rows, spacing_s, between);
                bridged[i] = far_from_rows(&times_s, &bridged[i], rows, spacing_s);
            }
            times_s = (0..rows).map(|k| times_s[0] + k as f64 * spacing_s).collect();
        }
        let channels = commands.split_off(drives);
        bridged.drain(..drives);
        Record {
            name: file_name(&self.experiment.file),
            engagement: self.experiment.engagement,
            is_check: self.experiment.role == Some(ExperimentRole::Check),
            repeat: self.experiment.repeat.clone(),
            start_s: times_s[0],
            times_s,
            spacing_s,
            commands,
            series: channels,
            bridged,
            silent,
            before: None,
        }
    }
}

/// The rows that were read, without those marked in `gaps`; all rows if `gaps` is empty.
fn read_rows(rows: usize, gaps: &[bool]) -> Vec<usize> {
    (0..rows).filter(|&k| gaps.get(k) != Some(&true)).collect()
}

fn is_constant(column: &[f64]) -> bool {
    column.iter().all(|x| x.to_bits() == column[0].to_bits())
}

/// Reports commands that are constant in every experiment while another command changes.
fn resting_commands(dataset: &Dataset, faults: &mut Vec<Fault>) {
    let Some(first) = dataset.records.first() else { return };
    for (i, driven) in dataset.drives.iter().enumerate() {
        if dataset.records.iter().all(|record| is_constant(&record.commands[i])) {
            let (file, column) = (first.name.clone(), Some(driven.column.clone()));
            faults.push(Fault { file, column, row: None, kind: FaultKind::RestingCommand });
        }
    }
}

/// Reports check experiments that repeat a fitted record row by row: they would score the fit, not a
/// prediction.
fn copied_checks(dataset: &Dataset, faults: &mut Vec<Fault>) {
    let has_same_rows = |a: &Record, b: &Record| a.commands == b.commands && a.series == b.series;
    for check in dataset.records.iter().filter(|record| record.is_check) {
        let mut fitted = dataset.records.iter().filter(|record| !record.is_check);
        if let Some(same) = fitted.find(|record| has_same_rows(check, record)) {
            let kind = FaultKind::CopiedCheck { fitted: same.name.clone() };
            faults.push(Fault { file: check.name.clone(), column: None, row: None, kind });
        }
    }
}

/// Reports experiments whose row spacing differs slightly from that of most others.
fn other_clocks(dataset: &Dataset, faults: &mut Vec<Fault>) {
    let mut spacings: Vec<f64> = dataset.records.iter().map(|record| record.spacing_s).collect();
    spacings.sort_by(f64::total_cmp);
    let Some(&usual_s) = spacings.get(spacings.len() / 2) else { return };
    let agree =
        spacings.iter().filter(|spacing| (*spacing / usual_s - 1.0).abs() < OTHER_CLOCK.start).count();
    if 2 * agree <= spacings.len() {
        return;
    }
    for record in dataset
        .records
        .iter()
        .filter(|record| OTHER_CLOCK.contains(&(record.spacing_s / usual_s - 1.0).abs()))
    {
        let kind = FaultKind::OtherSpacing { spacing_s: record.spacing_s, usual_s };
        faults.push(Fault { file: record.name.clone(), column: None, row: None, kind });
    }
}

fn time_faults(time: &[f64], first_row: usize, note: &mut impl FnMut(Option<usize>, FaultKind)) {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    if let Some(row) = steps.iter().position(|step| *step <= 0.0) {
        note(Some(row + 1 + first_row), FaultKind::TimeGoesBack);
        return;
    }
    let ordered = steps.clone();
    steps.sort_by(f64::total_cmp);
    let median = steps[steps.len() / 2];
    let lost = Lost::bridged(time);
    if let Some(Lost { rows, stretches, longest_s, longest_at }) = lost {
        note(Some(longest_at + first_row), FaultKind::LostRows { rows, stretches, longest_s });
    } else if let Some(row) = ordered.iter().position(|step| *step > GAP_FACTOR * median) {
        note(Some(row + 1 + first_row), FaultKind::Gap { seconds: ordered[row] - median });
    }
    let departures = ordered.iter().map(|step| (step / median - 1.0).abs()).enumerate();
    let most = if lost.is_some() { FIRST_LOST } else { GAP_FACTOR } - 1.0;
    let kept = departures.filter(|(_, share)| lost.is_none() || *share < most);
    if let Some((row, share)) = kept.max_by(|a, b| a.1.total_cmp(&b.1))
        && share > UNEVEN_SHARE
        && share <= most
    {
        note(Some(row + 1 + first_row), FaultKind::Uneven { share });
    }
}

/// The readings of a channel in every experiment, without interpolated values.
fn readings<'a>(channel: &'a Channel, tables: &'a [FileRows]) -> impl Iterator<Item = Vec<f64>> + 'a {
    tables.iter().filter_map(|table| {
        let column = table.header.iter().position(|header| *header == channel.column)?;
        let values = &table.columns[column];
        let gaps = table.bridged.get(column).map_or(&[][..], Vec::as_slice);
        let values: Vec<f64> = read_rows(values.len(), gaps).into_iter().map(|k| values[k]).collect();
        (values.len() >= FEWEST_ROWS && values.iter().all(|x| x.is_finite())).then_some(values)
    })
}

fn range(column: &[f64]) -> f64 {
    let (low, high) = extremes(column);
    high - low
}

fn extremes(column: &[f64]) -> (f64, f64) {
    column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)))
}

fn series_faults(
    column: &[f64],
    channel: &Channel,
    tells_place: bool,
    note: &mut impl FnMut(Option<usize>, FaultKind),
) {
    let noise = channel.noise;
    let step = quantum(column);
    let (low, high) = extremes(column);
    for extreme in [low, high] {
        let at = |x: f64| x.to_bits() == extreme.to_bits();
        let longest = column
            .chunk_by(|a, b| at(*a) == at(*b))
            .filter(|run| at(run[0]))
            .map(<[f64]>::len)
            .max()
            .unwrap_or(0);
        // A coarse channel at rest repeats its extreme value too. At a clipped channel noise is on one side
        // only.
        let rows = column.iter().filter(|&&x| at(x)).count();
        let share = rows as f64 / column.len() as f64;
        if longest >= CLIPPED_RUN
            && rows >= CLIPPED_ROWS
            && noise > 0.0
            && channel.resolution < noise
            && step.is_none()
        {
            let row = column.iter().position(|&x| at(x)).unwrap_or(0);
            note(Some(row), FaultKind::Clipped { value: extreme, share, tells_place });
        }
    }
    if let Some(step) = step.filter(|step| channel.is_coarse(*step)) {
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

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_time_that_goes_back_and_gaps_are_placed() {
        let mut faults = Vec::new();
        time_faults(&[0.0, 0.1, 0.2, 0.15, 0.4], 2, &mut |row, kind| faults.push((row, kind)));
        assert_eq!(faults, [(Some(5), FaultKind::TimeGoesBack)]);
        faults.clear();
        time_faults(&[0.0, 0.1, 0.2, 0.3, 0.4, 1.4, 1.5], 2, &mut |row, kind| faults.push((row, kind)));
        let [(Some(7), FaultKind::Gap { seconds })] = faults[..] else { panic!("one gap, in row 7") };
        assert!((seconds - 0.9).abs() < 1e-12);
    }
}
