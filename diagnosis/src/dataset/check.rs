//! Looks for faults of measured series, and makes records of those that are sound.

use feeler_files::Experiment;
use feeler_plant::description::{Engagement, Quantity};
use feeler_plant::names::nearest;

use super::bridge::{FIRST_LOST, Lost};
use super::fault::{Fault, FaultKind};
use super::{Channel, Dataset, Record, Table, file_name, role_is_check};

/// The column of time stamps.
const TIME: &str = "t_s";
/// Rows that a prediction needs.
const FEWEST_ROWS: usize = 50;
/// A spacing this many times the median is a gap, where the rows that are missing are too many to be bridged.
const GAP_FACTOR: f64 = 4.0;
/// Rows this many holds of a command apart are seconds that were taken for something else: what was commanded
/// in between is unknown.
const MOST_HOLDS: f64 = 100.0;
/// Departure from even spacing, in fractions of it, above which series are interpolated.
const UNEVEN_SHARE: f64 = 0.01;
/// Rows at an extreme value, and how many of them one after the other, that are taken for clipping: noise
/// hits the same value hardly twice.
const CLIPPED_ROWS: usize = 8;
const CLIPPED_RUN: usize = 3;
/// Difference of spacings, as a fraction, that is taken for a clock that runs fast or slow: more is another
/// rate, less is rounding.
const OTHER_CLOCK: std::ops::Range<f64> = 1e-3..0.1;
/// Variation over noise below which a series can tell little.
const WEAK_RATIO: f64 = 3.0;
/// The same below which not even the stated noise is in it.
const BELOW_NOISE: f64 = 0.8;
/// First row of data in a file with a header.
const FIRST_ROW: usize = 2;

/// Turns tables into records and gives every fault found on the way.
pub(super) fn assemble(
    dataset: &mut Dataset,
    experiments: &[Experiment],
    tables: Vec<Table>,
    holds: &[Option<f64>],
) -> Vec<Fault> {
    let mut faults = Vec::new();
    let grains: Vec<f64> = dataset.channels.iter().map(|channel| grain(channel, &tables)).collect();
    if dataset.drives.is_empty() {
        faults.push(Fault {
            file: dataset.name.clone(),
            column: None,
            row: None,
            kind: FaultKind::NoCommand,
        });
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
            if let Some(i) = table.header.iter().position(|header| header == name) {
                // A converter that writes -0 means 0.
                columns.push(table.columns[i].iter().map(|x| x + 0.0).collect::<Vec<f64>>());
            } else {
                let is_free = |header: &&String| *header != TIME && !names.contains(&header.as_str());
                let known: Vec<String> = table.header.iter().filter(is_free).cloned().collect();
                let within = known.iter().find(|header| header.contains(name)).map(String::as_str);
                let near = within.or_else(|| nearest(name, known.iter().map(String::as_str)));
                let near = near.map(str::to_owned);
                note(Some(name), None, FaultKind::MissingColumn { near, known });
            }
        }
        let mut time = table.columns.first().cloned().unwrap_or_default();
        if let Some(first) = table
            .header
            .first()
            .filter(|first| *first != TIME && table.header.iter().any(|header| header == TIME))
        {
            note(None, None, FaultKind::TimeNotFirst { first: first.clone() });
            continue;
        }
        if time.len() < FEWEST_ROWS {
            note(None, None, FaultKind::TooShort { rows: time.len() });
            continue;
        }
        if columns.len() < names.len() {
            continue;
        }
        for (name, column) in
            std::iter::once((&table.header[0].as_str(), &time)).chain(names.iter().zip(&columns))
        {
            if let Some(row) = column.iter().position(|x| !x.is_finite()) {
                let cells = column.iter().filter(|x| !x.is_finite()).count();
                note(Some(name), Some(row + FIRST_ROW), FaultKind::NotANumber { cells });
            }
        }
        time_faults(&time, &mut |row, kind| note(None, row, kind));
        let lost = Lost::bridged(&time).map_or(0, |lost| lost.rows);
        let rows = time.len() + lost;
        let spacing_s = (time[time.len() - 1] - time[0]) / (rows - 1) as f64;
        if let Some(hold_s) = holds.iter().flatten().copied().find(|hold_s| spacing_s > MOST_HOLDS * hold_s) {
            note(None, None, FaultKind::SlowRows { spacing_s, hold_s });
        }
        let drives = dataset.drives.len();
        let mut silent = vec![false; names.len() - drives];
        let mut is_lost = false;
        let is_clamped = experiment.engagement == Some(Engagement::Clamped);
        for (i, (name, column)) in names.iter().zip(&columns).enumerate() {
            // Noise and motion alike were rounded away: the step, which other experiments show, is the
            // finding.
            if i >= drives && grains[i - drives] > 0.0 && range(column) <= 2.0 * grains[i - drives] {
                continue;
            }
            let constant = column.iter().all(|x| x.to_bits() == column[0].to_bits());
            if constant && i < drives {
                note(Some(name), None, FaultKind::ConstantCommand);
            } else if i >= drives {
                let channel = &dataset.channels[i - drives];
                let tells_place = channel.quantity(&dataset.machine) == Quantity::Position;
                if constant {
                    // Held by the wall an encoder may well stand still.
                    let is_held = tells_place && is_clamped;
                    silent[i - drives] = !is_held;
                    is_lost |= tells_place && !is_held;
                    note(Some(name), None, FaultKind::Constant { tells_place: tells_place && !is_held });
                    continue;
                }
                // A force out of contact is nothing but noise, and must be.
                let is_idle = experiment.engagement == Some(Engagement::Free)
                    && channel.is_of_contact(&dataset.machine);
                series_faults(column, channel, tells_place, &mut |row, kind| {
                    let is_clipped = matches!(kind, FaultKind::Clipped { .. });
                    silent[i - drives] |= is_clipped;
                    is_lost |= is_clipped && tells_place;
                    if !(is_idle && matches!(kind, FaultKind::WeakExcitation { .. })) {
                        note(Some(name), row, kind);
                    }
                });
            }
        }
        if is_lost || faults[before..].iter().any(|fault| fault.kind.is_fatal()) {
            continue;
        }
        let is_uneven = |fault: &Fault| matches!(fault.kind, FaultKind::Uneven { .. });
        if lost > 0 || faults[before..].iter().any(is_uneven) {
            for (i, column) in columns.iter_mut().enumerate() {
                *column = regrid(&time, column, rows, spacing_s, i < drives && holds[i].is_some());
            }
            time = (0..rows).map(|k| time[0] + k as f64 * spacing_s).collect();
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
            silent,
        });
    }
    other_clocks(dataset, &mut faults);
    faults
}

/// Names experiments whose rows are spaced a little differently than those of most.
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

fn time_faults(time: &[f64], note: &mut impl FnMut(Option<usize>, FaultKind)) {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    if let Some(row) = steps.iter().position(|step| *step <= 0.0) {
        note(Some(row + 1 + FIRST_ROW), FaultKind::TimeGoesBack);
        return;
    }
    let ordered = steps.clone();
    steps.sort_by(f64::total_cmp);
    let median = steps[steps.len() / 2];
    let lost = Lost::bridged(time);
    if let Some(Lost { rows, stretches, longest_s, longest_at }) = lost {
        note(Some(longest_at + FIRST_ROW), FaultKind::LostRows { rows, stretches, longest_s });
    } else if let Some(row) = ordered.iter().position(|step| *step > GAP_FACTOR * median) {
        note(Some(row + 1 + FIRST_ROW), FaultKind::Gap { seconds: ordered[row] - median });
    }
    let departures = ordered.iter().map(|step| (step / median - 1.0).abs()).enumerate();
    let most = if lost.is_some() { FIRST_LOST } else { GAP_FACTOR } - 1.0;
    let kept = departures.filter(|(_, share)| lost.is_none() || *share < most);
    if let Some((row, share)) = kept.max_by(|a, b| a.1.total_cmp(&b.1))
        && share > UNEVEN_SHARE
        && share <= most
    {
        note(Some(row + 1 + FIRST_ROW), FaultKind::Uneven { share });
    }
}

/// The coarsest step, beyond what is believed, that a channel shows in any experiment; 0 if none.
fn grain(channel: &Channel, tables: &[Table]) -> f64 {
    let steps = tables.iter().filter_map(|table| {
        let column = table.header.iter().position(|header| *header == channel.column)?;
        let values = &table.columns[column];
        let usable = values.len() >= FEWEST_ROWS && values.iter().all(|x| x.is_finite());
        usable.then(|| quantum(values).filter(|step| channel.is_coarse(*step)))?
    });
    steps.fold(0.0, f64::max)
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
        // A coarse channel at rest repeats its extreme as well; a clipped one has left its noise behind on
        // one side only.
        let rows = column.iter().filter(|&&x| at(x)).count();
        let share = rows as f64 / column.len() as f64;
        if longest >= CLIPPED_RUN
            && rows >= CLIPPED_ROWS
            && noise > 0.0
            && channel.resolution < noise
            && step.is_none()
        {
            let row = column.iter().position(|&x| at(x)).unwrap_or(0);
            note(Some(row + FIRST_ROW), FaultKind::Clipped { value: extreme, share, tells_place });
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

/// The step of which all values are multiples, if there are few enough different values for it to show: the
/// smallest distance of different values, refined over all of them.
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
    // Refined by least squares on ever longer distances: an early error of the step would otherwise miscount
    // them.
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

fn regrid(time: &[f64], column: &[f64], rows: usize, spacing_s: f64, held: bool) -> Vec<f64> {
    let mut at = 0;
    (0..rows)
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
        let column: Vec<f64> =
            (0..4000).map(|k| ((f64::from(k) * 0.01).sin() / step).round() * step).collect();
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
        assert!(
            matches!(faults.as_slice(), [(Some(7), FaultKind::Gap { seconds })] if (seconds - 0.9).abs() < 1e-12)
        );
    }
}
