//! The page that compares scenarios or datasets.

mod differences;
mod planes;
mod taken;

use feeler_analysis::Curves;
use feeler_diagnosis::dataset::Dataset;
use feeler_lti::C64;
use feeler_studies::run::{RunResult, Summary};

pub(crate) use differences::{ComparedDatasets, ComparedScenarios, differing};
pub(crate) use taken::Taken;

use differences::onto;
use taken::LoopFigures;

use crate::numbers::{count, percent, plain, with_unit};
use crate::pages::analyze::{as_set, degrees};
use crate::pages::parts::{Chart, ChartKind, Line, MOST_VALUES, Page, Series, by_extremes};
use crate::units::Units;
use crate::words;

/// A function from the values of a response to numbers for a chart.
type Shown<'a> = &'a dyn Fn(&[C64]) -> Vec<f64>;

/// Largest number of rows of the common time axis.
const MOST_ROWS: usize = 100_000;

/// Headings of a table with a column for each scenario.
pub(crate) fn heads(taken: &[Taken]) -> Vec<&str> {
    std::iter::once("").chain(taken.iter().map(|one| one.name.as_str())).collect()
}

/// Rows of a table, one for each figure.
pub(crate) fn figures(taken: &[Taken]) -> Vec<Vec<String>> {
    let none = || "-".to_owned();
    let of_run = |name: &str, of: &dyn Fn(&Summary, Units) -> String| {
        let values = taken.iter().map(|one| one.run().map_or_else(none, |run| of(&run.summary, one.units())));
        std::iter::once(name.to_owned()).chain(values).collect::<Vec<_>>()
    };
    let of_theory = |name: &str, of: &dyn Fn(&LoopFigures) -> Option<String>| {
        let value = |one: &Taken| one.figures().and_then(|figures| of(&figures)).unwrap_or_else(none);
        std::iter::once(name.to_owned()).chain(taken.iter().map(value)).collect::<Vec<_>>()
    };
    let hz = |value: f64| with_unit(value, "Hz");
    // Figures of an unstable loop are theoretical only.
    let stable = |figures: &LoopFigures, figure| match figures.is_stable {
        Some(false) => Some("unstable".to_owned()),
        _ => figure,
    };
    vec![
        of_run("outcome", &|summary, _| words::label(summary).to_owned()),
        of_run("peak force", &|summary, units| with_unit(summary.peak_force_n, units.force)),
        of_run("overshoot", &|s, _| s.overshoot.map_or_else(none, |share| format!("{} %", percent(share)))),
        of_run("settling time", &|s, _| s.settling_time_s.map_or_else(none, |time| with_unit(time, "s"))),
        of_run("bounces", &|summary, _| summary.bounces.to_string()),
        of_run("oscillates at", &|s, _| s.oscillation.map_or_else(none, |o| hz(o.frequency_hz))),
        of_theory("gain", &|f| f.gain.map(plain)),
        of_theory("stability limit", &|f| f.largest_stable_gain.map(plain)),
        of_theory("phase margin", &|f| stable(f, f.phase_margin_deg.map(|deg| format!("{}°", plain(deg))))),
        of_theory("gain margin, of all gains", &|f| stable(f, f.gain_margin.map(plain))),
        of_theory("largest sensitivity", &|f| stable(f, f.largest_sensitivity.map(plain))),
        of_theory("bandwidth", &|f| stable(f, f.bandwidth_hz.map(hz))),
    ]
}

/// Limit of unstable step responses in a chart, over the largest stable one.
const BESIDE_STABLE: f64 = 1.5;

/// The page of scenarios.
pub(crate) fn page(taken: &[Taken]) -> String {
    let names: Vec<&str> = taken.iter().map(|one| one.name.as_str()).collect();
    let mut page = Page::new(&names.join(" against "), "");
    let keys = differing(taken);
    page.lead(&match keys.len() {
        0 => "No key differs: these scenarios are the same.".to_owned(),
        number => {
            format!("{} differ.", count(number, "key", "keys")).replace("1 key differ.", "1 key differs.")
        }
    });
    for one in taken {
        let outcome = one.run().map(|run| words::outcome(&run.summary, one.units()));
        let set = one.theory().and_then(|(report, _)| as_set(report));
        let said: Vec<String> = outcome.into_iter().chain(set).collect();
        page.paragraph(&format!("{}: {}", one.name, said.join(" ")));
    }
    if !keys.is_empty() {
        page.heading("What differs");
        page.versus(&heads(taken), &keys);
    }
    page.heading("Outcomes");
    page.versus(&heads(taken), &figures(taken));
    page.heading("Runs");
    page.paragraph("Drag across a chart to zoom; double-click to see the whole again.");
    for chart in over_time(taken) {
        page.chart(&chart);
    }
    page.heading("Linear theory");
    for chart in theory(taken) {
        page.chart(&chart);
    }
    planes::draw(taken, &mut page);
    page.render()
}

/// The force of the main contact, and the command of the first drive, of every run.
fn over_time(taken: &[Taken]) -> Vec<Chart> {
    let runs: Vec<(&Taken, &RunResult)> = taken.iter().filter_map(|one| Some((one, one.run()?))).collect();
    let end_s = runs.iter().filter_map(|(_, run)| run.record.t_s.last()).fold(0.0_f64, |a, b| a.max(*b));
    let rows = runs.iter().map(|(_, run)| run.record.t_s.len()).max().unwrap_or(0).min(MOST_ROWS);
    if rows < 2 {
        return Vec::new();
    }
    let t_s: Vec<f64> = (0..rows).map(|i| end_s * i as f64 / (rows - 1) as f64).collect();
    let force =
        |_: &Taken, run: &RunResult| Some(run.contacts.get(run.summary.main_contact?)?.force_signal());
    let command = |one: &Taken, _: &RunResult| {
        Some(format!("{}.command", one.document.scenario.machine.actuators.keys().next()?))
    };
    let chart = |title: &str, signal: &dyn Fn(&Taken, &RunResult) -> Option<String>, unit: &str| {
        let quantity = title.trim_end_matches('.').to_lowercase();
        let label = if unit.is_empty() { quantity } else { format!("{quantity} ({unit})") };
        let mut chart = Chart::new(ChartKind::Line, title, "time (s)", label);
        chart.together = Some("run");
        let mut series = Vec::new();
        for (one, run) in &runs {
            let column = signal(one, run).and_then(|name| run.record.column(&name));
            series.extend(
                column.map(|column| Series::new(&one.name, unit, onto(&run.record.t_s, column, &t_s))),
            );
        }
        let columns: Vec<&[f64]> = series.iter().map(|series| series.values.as_slice()).collect();
        let kept = by_extremes(&columns, rows, MOST_VALUES / (4 * columns.len().max(1)));
        chart.x = kept.iter().map(|&i| t_s[i]).collect();
        for series in &mut series {
            series.values = kept.iter().map(|&i| series.values[i]).collect();
        }
        chart.series = series;
        Some(chart).filter(|chart| !chart.series.is_empty())
    };
    let force_unit = taken.first().map_or("N", |one| one.units().force);
    let unit_of =
        |one: &Taken| Some(one.units().command(one.document.scenario.machine.actuators.values().next()?));
    let units: Vec<&str> = runs.iter().filter_map(|(one, _)| unit_of(one)).collect();
    // Commands of different kinds have no common unit.
    let common = units.first().copied().filter(|first| units.iter().all(|unit| unit == first));
    [chart("Contact force.", &force, force_unit), chart("Command.", &command, common.unwrap_or_default())]
        .into_iter()
        .flatten()
        .collect()
}

/// Step responses and open loops in common charts.
fn theory(taken: &[Taken]) -> Vec<Chart> {
    let known: Vec<(&str, &Curves)> =
        taken.iter().filter_map(|one| Some((one.name.as_str(), &one.theory()?.1))).collect();
    let mut charts = Vec::new();
    let steps: Vec<_> =
        known.iter().filter_map(|(name, curves)| Some((*name, curves.step.as_ref()?))).collect();
    if !steps.is_empty() {
        let mut chart = Chart::new(ChartKind::Line, "Step response,", "time (s)", "reading over reference");
        chart.caption = "linear, sampled, gains as set.".into();
        let times = |step: &feeler_analysis::StepResponse| {
            (0..step.values.len()).map(|k| k as f64 * step.period_s).collect::<Vec<_>>()
        };
        chart.x = steps.iter().flat_map(|(_, step)| times(step)).collect();
        chart.x.sort_by(f64::total_cmp);
        chart.x.dedup();
        let bound = shown_up_to(taken);
        chart.series = (steps.iter())
            .map(|(name, step)| {
                let mut values = onto(&times(step), &step.values, &chart.x);
                if let Some(beyond) = values.iter().position(|value| value.abs() > bound) {
                    values[beyond..].fill(f64::NAN);
                }
                Series::new(*name, "", values)
            })
            .collect();
        if bound.is_finite() {
            chart.caption.push_str(" An unstable response ends where it leaves the others.");
        }
        chart.lines.push(Line { y: 1.0, label: "reference".into() });
        charts.push(chart);
    }
    let loops: Vec<_> = known
        .iter()
        .filter_map(|(name, curves)| Some((*name, &curves.frequencies_hz, curves.open_sampled.as_ref()?)))
        .collect();
    let mut frequencies: Vec<f64> = loops.iter().flat_map(|(_, hz, _)| (*hz).clone()).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    let decibels = |values: &[C64]| values.iter().map(|l| 20.0 * l.norm().log10()).collect::<Vec<_>>();
    let kinds: [(&str, &str, Shown, f64); 2] =
        [("magnitude (dB)", "dB", &decibels, 0.0), ("phase (°)", "°", &degrees, -180.0)];
    for (label, unit, of, line) in kinds {
        if loops.is_empty() {
            continue;
        }
        let mut chart = Chart::new(ChartKind::Line, "Open loop,", "frequency (Hz)", label);
        chart.caption = "sampled, broken at the controller, gains as set.".into();
        (chart.x_log, chart.together) = (true, Some("frequency"));
        chart.x.clone_from(&frequencies);
        chart.series = (loops.iter())
            .map(|(name, hz, values)| Series::new(*name, unit, onto(hz, &of(values), &frequencies)))
            .collect();
        chart.lines.push(Line { y: line, label: format!("{line} {unit}") });
        charts.push(chart);
    }
    charts
}

/// Limit at which unstable step responses are cut so that stable ones remain visible. Infinite unless there
/// are both.
fn shown_up_to(taken: &[Taken]) -> f64 {
    let of = |stable: bool| {
        let such = taken.iter().filter(move |one| {
            one.figures().is_some_and(|figures| figures.is_stable.is_some_and(|is| is == stable))
        });
        such.filter_map(|one| one.theory()?.1.step.as_ref()).flat_map(|step| &step.values)
    };
    match (of(true).map(|value| value.abs()).reduce(f64::max), of(false).next()) {
        (Some(largest), Some(_)) => BESIDE_STABLE * largest,
        _ => f64::INFINITY,
    }
}

/// The page of datasets: records with common columns, in common charts.
pub(crate) fn datasets(sets: &[Dataset]) -> String {
    let names: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
    let mut page = Page::new(&names.join(" against "), "");
    page.lead(&format!(
        "{} with {}.",
        names.join(" and "),
        sets.iter()
            .map(|set| count(set.records.len(), "record", "records"))
            .collect::<Vec<_>>()
            .join(" and ")
    ));
    let Some(first) = sets.first() else { return page.render() };
    match ComparedDatasets::new(sets).rows() {
        rows if rows.is_empty() => page.paragraph(NOTHING_COMMON),
        rows => page.table(&RECORD_HEADS, &[3, 4, 5], &rows),
    }
    for record in &first.records {
        let same: Vec<_> = (sets.iter())
            .filter_map(|set| Some((set, set.records.iter().find(|other| other.name == record.name)?)))
            .collect();
        if same.len() < 2 {
            continue;
        }
        page.heading(&record.name);
        for channel in &first.channels {
            let unit = Units::of(&first.machine).unit(channel.quantity(&first.machine));
            let label = format!("{} ({unit})", channel.column);
            let mut chart = Chart::new(ChartKind::Line, format!("{},", channel.column), "time (s)", label);
            chart.caption = "from the start of each record.".into();
            chart.together = Some("run");
            chart.x = record.times_s.iter().map(|t| t - record.times_s[0]).collect();
            for (set, other) in &same {
                let Some(c) = set.channels.iter().position(|own| own.column == channel.column) else {
                    continue;
                };
                let times: Vec<f64> = other.times_s.iter().map(|t| t - other.times_s[0]).collect();
                chart.series.push(Series::new(&set.name, unit, onto(&times, &other.series[c], &chart.x)));
            }
            page.chart(&chart);
        }
    }
    page.render()
}

/// The message for datasets without common records.
pub(crate) const NOTHING_COMMON: &str =
    "The first dataset shares no record with another, or no column of one: there is nothing to compare.";
/// Headings of the differences between datasets.
pub(crate) const RECORD_HEADS: [&str; 6] =
    ["record", "against", "column", "variation", "difference", "share"];
