//! Measurement and prediction, before and after repair, on experiments that were never fitted.

use feeler_diagnosis::Examination;
use feeler_diagnosis::dataset::{Channel, Record};
use feeler_diagnosis::replay::Replay;
use feeler_plant::description::{Engagement, Quantity};

use crate::numbers::{fine_percent, prefix};
use crate::pages::parts::{Chart, ChartKind, Page, Series, by_extremes};
use crate::units::Units;

/// Largest number of check experiments in charts; those with the largest error of each engagement come first.
const MOST_EXPERIMENTS: usize = 5;
/// Rows of a chart.
pub(super) const MOST_ROWS: usize = 1500;
/// Channels whose variation is below this multiple of their noise show only noise.
const LEAST_OVER_NOISE: f64 = 2.0;
/// Charts that zoom together: one name per experiment.
const TOGETHER: [&str; MOST_EXPERIMENTS] = ["first", "second", "third", "fourth", "fifth"];

/// Adds the charts to a page.
pub(super) fn add(page: &mut Page, answer: &Examination, units: Units) {
    let shown = shown(answer);
    if shown.is_empty() {
        return;
    }
    page.heading("Measured against predicted");
    page.paragraph(
        "Experiments that were never fitted. Predictions start from the measured motion every 50 ms and run \
         freely in between. Positions stay so \
         close that their error is drawn instead. Drag across a chart to zoom, the others of the same \
         experiment follow; double-click to go back.",
    );
    for ([before, after], together) in shown.into_iter().zip(TOGETHER) {
        let record = &answer.dataset.records[before.record];
        let channels = answer.dataset.channels.iter().enumerate();
        let (noisy, shown): (Vec<_>, Vec<_>) =
            channels.partition(|(c, channel)| before.errors[*c].scale < LEAST_OVER_NOISE * channel.noise);
        let silent: Vec<&str> = noisy.iter().map(|(_, channel)| channel.column.as_str()).collect();
        let silent = if silent.is_empty() {
            String::new()
        } else {
            format!(" ({} shows nothing but noise and is not drawn)", silent.join(", "))
        };
        page.paragraph(&format!(
            "{}{}{silent}:",
            record.name,
            record.engagement.map_or_else(String::new, |e| format!(", {}", engagement(e)))
        ));
        for (c, channel) in shown {
            let quantity = channel.quantity(&answer.dataset.machine);
            let mut chart = chart(record, channel, c, [before, after], quantity, units);
            chart.together = Some(together);
            page.chart(&chart);
        }
    }
}

/// The experiments with the largest error of each engagement, then others, in the order of the dataset.
fn shown(answer: &Examination) -> Vec<[&Replay; 2]> {
    let error =
        |replay: &Replay| replay.errors.iter().map(|error| error.relative_in_windows.powi(2)).sum::<f64>();
    let mut ranked: Vec<&[Replay; 2]> = answer.replays.iter().collect();
    ranked.sort_by(|a, b| error(&b[0]).total_cmp(&error(&a[0])));
    let kind = |pair: &[Replay; 2]| answer.dataset.records[pair[0].record].engagement.map(engagement);
    let mut kinds = Vec::new();
    let (mut first, mut rest) = (Vec::new(), Vec::new());
    for pair in ranked {
        if kinds.contains(&kind(pair)) {
            rest.push(pair);
        } else {
            kinds.push(kind(pair));
            first.push(pair);
        }
    }
    first.extend(rest);
    first.truncate(MOST_EXPERIMENTS);
    first.sort_by_key(|pair| pair[0].record);
    first.into_iter().map(|[before, after]| [before, after]).collect()
}

fn engagement(engagement: Engagement) -> &'static str {
    match engagement {
        Engagement::Free => "free",
        Engagement::Clamped => "clamped",
        Engagement::Unilateral => "contact that only pushes",
    }
}

fn chart(
    record: &Record,
    channel: &Channel,
    c: usize,
    [before, after]: [&Replay; 2],
    quantity: Quantity,
    units: Units,
) -> Chart {
    let unit = units.unit(quantity);
    let measured = &record.series[c];
    let is_error = quantity == Quantity::Position;
    let off = |predicted: &[f64]| measured.iter().zip(predicted).map(|(m, p)| m - p).collect::<Vec<f64>>();
    // Each machine has the same colour in all charts. Its curve lies over the measurement, so that the
    // measured noise remains visible.
    let machines = |of: &dyn Fn(&[f64]) -> Vec<f64>| -> [(&'static str, Vec<f64>, usize); 2] {
        [("machine as given", of(&before.windows[c]), 0), ("repaired machine", of(&after.windows[c]), 1)]
    };
    let columns: Vec<(&str, Vec<f64>, usize)> = if is_error {
        machines(&off).into()
    } else {
        [("measured", measured.clone(), 2)].into_iter().chain(machines(&<[f64]>::to_vec)).collect()
    };
    // Position errors are micrometres, so their axis has a prefix.
    let largest = columns.iter().flat_map(|(_, values, _)| values).fold(0.0_f64, |m, x| m.max(x.abs()));
    let (scale, size) = if is_error { prefix(largest) } else { (1.0, "") };
    let unit = format!("{size}{unit}");
    let slices: Vec<&[f64]> = columns.iter().map(|(_, values, _)| values.as_slice()).collect();
    let kept = by_extremes(&slices, measured.len(), MOST_ROWS);
    let share = |replay: &Replay| fine_percent(replay.errors[c].relative_in_windows);
    let title = if is_error {
        format!("{}, measured less predicted;", channel.column)
    } else {
        format!("{};", channel.column)
    };
    let mut chart = Chart::new(
        ChartKind::Line,
        title,
        "time (s)",
        format!("{} ({unit})", if is_error { "error" } else { quantity.name() }),
    );
    chart.caption = format!(
        "error {} % of its variation with the machine as given, {} % with the repaired machine.",
        share(before),
        share(after)
    );
    chart.x = kept.iter().map(|&k| record.start_s + k as f64 * record.spacing_s).collect();
    chart.series = columns
        .iter()
        .map(|(name, values, colour)| {
            let values = kept.iter().map(|&k| values[k] / scale).collect();
            let series = Series::new(*name, &unit, values).coloured(*colour);
            match *name {
                "measured" => series.measured(),
                _ if *colour == 0 => series.dashed(),
                _ => series,
            }
        })
        .collect();
    chart
}
