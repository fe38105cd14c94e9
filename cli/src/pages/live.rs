//! The live page: its parts, and each of its states.

use std::fmt::Write as _;

use feeler_analysis::{AnalysisError, Curves, Report};
use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::replay::Replay;
use feeler_files::Document;
use feeler_plant::description::Machine;
use feeler_studies::Doubts;
use feeler_studies::run::{Outcome, RunError, RunResult};
use serde_json::{Map, Value, json};

use crate::numbers::with_unit;
use crate::pages::analyze::{as_set, loci, nyquist, open_loop, step, tiles};
use crate::pages::parts::{
    Chart, ChartKind, Plane, Series, by_extremes, escape, own_page, prose, tiles_html,
};
use crate::pages::run;
use crate::pages::sweep::of_outcome;
use crate::units::Units;
use crate::words;

const STYLE: &str = include_str!("../../assets/live.css");
const MAP_SCRIPT: &str = include_str!("../../assets/live-map.js");
const SCRIPT: &str = include_str!("../../assets/live.js");

/// Smallest distance between drawn points of a plane, as a share of the frame.
const STEP: f64 = 3e-3;
/// Distance in frames beyond which a curve is clipped.
const FAR: f64 = 3.0;
/// Rows of a chart of records.
const MOST_ROWS: usize = 4000;

/// Sections of the page, in reading order: name, kind, heading.
const PLACES: [[&str; 3]; 9] = [
    ["force", "chart", "Contact force"],
    ["drive", "chart", "Drive"],
    ["step", "chart", "Step response, linear"],
    ["magnitude", "chart", "Open loop, magnitude"],
    ["phase", "chart", "Open loop, phase"],
    ["nyquist", "plane", "Nyquist's curve"],
    ["locus", "plane", "Root locus"],
    ["map", "map", "Outcome over two numbers"],
    ["records", "records", "Measured records"],
];

/// The page: sliders for the numbers of a file, and sections for the results. `chunk` is the number of map
/// points in one request.
pub(crate) fn page(document: &Document, path: &str, records: &[&str], file: &Value, chunk: usize) -> String {
    let machine = &document.scenario.machine;
    let mut body = format!(
        "<header><h1>{}</h1><p class=\"about\">{}</p></header>\n<div class=\"live\">\
         <form id=\"knobs\" aria-label=\"numbers of the file\"></form>\
         <div class=\"views\"><p class=\"lead\" id=\"lead\" aria-live=\"polite\"></p>\
         <p id=\"stable\"></p><p id=\"problem\" role=\"alert\"></p><div id=\"tiles\">\
         <div id=\"tiles-run\"></div><div id=\"tiles-theory\"></div></div>",
        escape(&machine.name),
        prose(&machine.about)
    );
    let mut places: Vec<_> = PLACES.into_iter().filter(|[_, kind, _]| *kind != "records").collect();
    if !records.is_empty() {
        // A machine without controllers moves only in its records, so these come first.
        let first = document.scenario.controllers.is_empty();
        places.insert(if first { 0 } else { places.len() }, PLACES[PLACES.len() - 1]);
    }
    for [name, kind, heading] in places {
        let _ = write!(
            body,
            "<figure id=\"of-{name}\"><figcaption><b>{heading}</b></figcaption>\
             <div class=\"{kind}\" id=\"{name}\" tabindex=\"0\" role=\"group\" \
             aria-label=\"{heading}\"></div></figure>"
        );
    }
    body.push_str("</div></div>\n");
    let outcomes: Map<String, Value> = (Outcome::ALL.iter())
        .map(|(outcome, name)| {
            ((*name).to_owned(), json!({ "colour": of_outcome(name), "label": outcome.words() }))
        })
        .collect();
    let gain = document.scenario.controllers.iter().find_map(|(name, used)| {
        feeler_analysis::leading_gain(&used.spec).map(|gain| format!("controllers.{name}.{gain}"))
    });
    let data = json!({
        "charts": [], "planes": [], "maps": [], "scenes": [],
        "path": path, "file": file, "outcomes": outcomes, "gain": gain, "records": records,
        "chunk": chunk,
    });
    own_page(&format!("{} · live", machine.name), STYLE, &body, &data, &[MAP_SCRIPT, SCRIPT])
}

/// One state of the page, or a part of it.
pub(crate) struct Shown<'a> {
    pub(crate) document: &'a Document,
    pub(crate) run: Option<Result<RunResult, RunError>>,
    pub(crate) theory: Option<Result<(Report, Curves), AnalysisError>>,
    /// The duration of the whole run, s, if only its beginning was simulated.
    pub(crate) cut_from_s: Option<f64>,
    /// Doubts about the file; empty unless the run is undecided.
    pub(crate) doubts: Doubts,
    /// Whether all figures are included.
    pub(crate) has_all: bool,
}

impl Shown<'_> {
    pub(crate) fn to_json(&self) -> Value {
        let units = Units::of(&self.document.scenario.machine);
        let (mut charts, mut planes) = (Map::new(), Map::new());
        let (mut said, mut figures, mut problems) = (Vec::new(), Vec::new(), Vec::new());
        let mut outcome = Value::Null;
        match &self.run {
            Some(Ok(result)) => {
                for (name, chart) in ["force", "drive"].into_iter().zip(run::overview(self.document, result))
                {
                    charts.insert(name.into(), up_to(chart, self.cut_from_s).to_json());
                }
                outcome = json!(result.summary.outcome.name());
                // A shortened run is undecided because it is short, which needs no words.
                if self.cut_from_s.is_none() || result.summary.outcome != Outcome::Undecided {
                    let account =
                        words::account(&self.document.scenario, &result.summary, units, &self.doubts);
                    said.extend(account.sentences);
                }
                said.extend(self.cut_from_s.map(|whole_s| {
                    format!(
                        "In motion: the first {} of {}.",
                        with_unit(result.summary.simulated_s, "s"),
                        with_unit(whole_s, "s")
                    )
                }));
                figures.extend(run::tiles(&result.summary, units, None));
            }
            Some(Err(error)) => problems.push(error.to_string()),
            None => {}
        }
        let mut stable = String::new();
        match &self.theory {
            Some(Ok((report, curves))) => {
                theory(report, curves, &mut charts, &mut planes);
                stable = stable_gains(report);
                said.extend(as_set(report));
                figures.extend(tiles(report));
            }
            Some(Err(error)) => problems.push(format!("no linear theory: {error}")),
            None => {}
        }
        json!({
            "outcome": outcome, "lead": said.join(" "), "stable": stable, "problem": problems.join("\n"),
            "tiles": tiles_html(&figures), "charts": charts, "planes": planes,
            "partial": self.cut_from_s.is_some() || !self.has_all,
        })
    }
}

/// A chart of a shortened run, on the time axis of the whole run.
fn up_to(mut chart: Chart, end_s: Option<f64>) -> Chart {
    if let Some(end_s) = end_s {
        chart.x.push(end_s);
        for series in &mut chart.series {
            series.values.push(f64::NAN);
        }
    }
    chart
}

/// Curves of linear theory.
fn theory(
    report: &Report,
    curves: &Curves,
    charts: &mut Map<String, Value>,
    planes: &mut Map<String, Value>,
) {
    for (name, chart) in ["magnitude", "phase"].into_iter().zip(open_loop(report, curves)) {
        charts.insert(name.into(), chart.to_json());
    }
    charts.extend(step(curves).map(|chart| ("step".to_owned(), chart.to_json())));
    let locus = loci(report, curves).into_iter().next();
    for (name, plane) in [("nyquist", nyquist(report, curves)), ("locus", locus)] {
        planes.extend(plane.map(|plane| (name.to_owned(), thinned(plane).to_json())));
    }
}

/// The stable values of the gain in question, each interval with its frequency of oscillation.
fn stable_gains(report: &Report) -> String {
    let Some(gain) = report.gain() else { return String::new() };
    let spans: Vec<String> = (gain.sampled.intervals.iter())
        .map(|band| {
            let end = |edge: Option<&feeler_analysis::Edge>, none: &str| match edge {
                // The search ends at zero.
                Some(edge) if edge.gain == 0.0 && edge.frequency_hz == 0.0 => "0".to_owned(),
                Some(edge) => {
                    format!("{} ({})", crate::numbers::plain(edge.gain), with_unit(edge.frequency_hz, "Hz"))
                }
                None => none.to_owned(),
            };
            format!("{} to {}", end(band.lower.as_ref(), "−∞"), end(band.upper.as_ref(), "∞"))
        })
        .collect();
    let spans = if spans.is_empty() { "nowhere".to_owned() } else { spans.join(" and ") };
    format!("Stable {}, sampled, in contact: {spans}.", gain.key)
}

/// The plane with only as many points as are visible.
fn thinned(mut plane: Plane) -> Plane {
    let [left, right, low, high] = plane.view;
    let (width, height) = (right - left, high - low);
    let seen = |[x, y]: [f64; 2]| {
        [((x - left) / width - 0.5).clamp(-FAR, FAR), ((y - low) / height - 0.5).clamp(-FAR, FAR)]
    };
    for path in &mut plane.paths {
        let mut kept: Vec<usize> = Vec::new();
        for (i, point) in path.points.iter().enumerate() {
            let far = kept.last().is_none_or(|&j| {
                let ([x, y], [a, b]) = (seen(*point), seen(path.points[j]));
                // A NaN separates two curves and is kept.
                let far = (x - a).hypot(y - b);
                far.is_nan() || far >= STEP
            });
            if far || i + 1 == path.points.len() {
                kept.push(i);
            }
        }
        path.points = kept.iter().map(|&i| path.points[i]).collect();
        path.at = kept.iter().map(|&i| path.at[i]).collect();
    }
    plane
}

/// Charts of each channel of a record: measured, predicted by the present machine, and by the repaired one.
pub(crate) fn records(
    machine: &Machine,
    dataset: &Dataset,
    index: usize,
    believed: Option<&Replay>,
    repaired: Option<&Replay>,
) -> Vec<Value> {
    let Some(record) = dataset.records.get(index) else { return Vec::new() };
    let units = Units::of(machine);
    let chart = |(c, measured): (usize, &Vec<f64>)| {
        let channel = &dataset.channels[c];
        let unit = units.unit(channel.quantity(machine));
        let curves: Vec<(&str, &[f64])> = [
            Some(("measured", measured.as_slice())),
            believed.map(|replay| ("the machine as set", replay.windows[c].as_slice())),
            repaired.map(|replay| ("repaired", replay.windows[c].as_slice())),
        ]
        .into_iter()
        .flatten()
        .collect();
        let columns: Vec<&[f64]> = curves.iter().map(|(_, column)| *column).collect();
        let kept = by_extremes(&columns, measured.len(), MOST_ROWS);
        let mut chart = Chart::new(
            ChartKind::Line,
            channel.column.clone(),
            "time (s)",
            format!("{} ({unit})", channel.column),
        );
        chart.together = Some("records");
        chart.x = kept.iter().map(|&i| record.times_s[i] - record.times_s[0]).collect();
        let curve = |(i, (name, column)): (usize, (&str, &[f64]))| {
            let series = Series::new(name, unit, kept.iter().map(|&row| column[row]).collect());
            if i == 0 { series.measured() } else { series.coloured(i - 1) }
        };
        chart.series = curves.into_iter().enumerate().map(curve).collect();
        chart.to_json()
    };
    record.series.iter().enumerate().map(chart).collect()
}
