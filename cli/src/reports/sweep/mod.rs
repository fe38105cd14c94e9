//! The page of a sweep: maps over two axes, diagrams over one, and what each variant came to.

mod bifurcation;
mod cycles;
mod drawn;
mod map;
mod palette;
mod png;
mod svg;
mod tally;

use std::path::{Path, PathBuf};

use feeler_scenarios::run::Outcome;
use feeler_scenarios::sweep::{Column, DrawnAxis, Sweep, Table, panels};
use serde_json::{Value, json};

use bifurcation::{Diagram, Prediction};
use cycles::Theory;
use drawn::Drawn;
use map::{Colouring, Map};
pub(crate) use tally::Tally;

use crate::numbers::{percent, plain};
use crate::page::{Page, Tile};
use crate::{results, words};

/// Panels that are drawn; more are left to the table.
const MOST_PANELS: usize = 8;
/// Measures that the pointer shows, with their units.
const SHOWN: [(&str, &str); 6] = [
    ("peak_force_n", "N"),
    ("settling_time_s", "s"),
    ("frequency_hz", "Hz"),
    ("amplitude_n", "N"),
    ("chatter_contact_share", ""),
    ("growth_per_s", "1/s"),
];

/// Lists that only diagrams show.
const TAILS: [&str; 2] = ["impact_peaks_n", "strobe_n"];

/// Writes page and drawings of the results in `path`, and gives their paths.
pub(crate) fn write(sweep: &Sweep, name: &str, path: &Path, tally: &Tally, folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let axes = DrawnAxis::of(&sweep.file);
    let drawn = Drawn::of(&sweep.file, tally.rows);
    let is_shown = |column: &str| {
        let tail = axes.len() == 1 && TAILS.contains(&column);
        tail || ["outcome", "error"].contains(&column)
            || sweep.file.axes.contains_key(column)
            || SHOWN.iter().any(|(name, _)| *name == column)
    };
    let table = Table::read_part(path, &is_shown, &|row| drawn.has(row))?;
    let outcomes = tally::outcomes(&table).map(str::to_owned).collect();
    let report = Report { sweep, table: &table, tally, drawn, axes, outcomes };
    let mut page = Page::new(name, &sweep.file.about);
    page.lead(&report.lead());
    page.tiles(&report.tiles());
    let mut drawings: Vec<(String, String)> = Vec::new();
    match report.axes.as_slice() {
        [] => page.paragraph("No axis of this sweep runs over a range of numbers, so that there is nothing to draw."),
        [axis] => report.diagrams(axis, &mut page, &mut drawings),
        [x, y, ..] => report.maps([x, y], &mut page, &mut drawings),
    }
    report.counts(&mut page);
    page.heading("Scenario");
    page.verbatim("the file whose keys are varied", sweep.document.text());
    let mut written = Vec::new();
    let mut pixels: Vec<(&str, PathBuf)> = Vec::new();
    for (name, svg) in &drawings {
        let path = folder.join(format!("{name}.svg"));
        results::put(&path, svg.as_bytes())?;
        let png = path.with_extension("png");
        written.extend([path, png.clone()]);
        pixels.push((svg, png));
    }
    png::write(&pixels)?;
    let path = folder.join("report.html");
    results::put(&path, page.render().as_bytes())?;
    written.push(path);
    Ok(written)
}

struct Report<'a> {
    sweep: &'a Sweep,
    /// The variants that are drawn.
    table: &'a Table,
    /// Figures of all variants.
    tally: &'a Tally,
    drawn: Drawn,
    axes: Vec<DrawnAxis>,
    /// By row of the table; `error` where a variant failed, `done` where outcomes are not kept.
    outcomes: Vec<String>,
}

impl Report<'_> {
    fn lead(&self) -> String {
        let rows = self.tally.rows;
        let thinned = if self.axes.is_empty() { String::new() } else { self.drawn.words(self.table.rows) };
        if !self.sweep.file.keep.outcome {
            return format!("{rows} variants have run; the sweep keeps no outcomes.{thinned}");
        }
        let of = |outcome: &(Outcome, &str)| self.tally.count(outcome.1);
        let stable: usize = Outcome::ALL.iter().filter(|(outcome, _)| outcome.is_stable()).map(of).sum();
        let share = |count: usize| percent(count as f64 / rows.max(1) as f64);
        let chatter = self.tally.count("chatter");
        format!("Of {rows} variants {} % settle and {} % chatter.{thinned}", share(stable), share(chatter))
    }

    fn tiles(&self) -> Vec<Tile> {
        let tile = |name, value: String, remark: &str| Tile { name, value, remark: remark.into() };
        let mut tiles = vec![tile("variants", self.tally.rows.to_string(), "")];
        if let Some(largest_n) = self.tally.largest_peak_n {
            tiles.push(tile("largest peak force", format!("{} N", plain(largest_n)), "of any variant"));
        }
        if self.sweep.file.keep.outcome {
            tiles.push(tile("undecided", self.tally.count("undecided").to_string(), "at the end of the extended run"));
        }
        tiles.push(tile("failed", self.tally.count("error").to_string(), "their rows say why"));
        if let Some(grid) = self.sweep.runs_of_the_grid() {
            let share = percent(self.tally.rows as f64 / grid as f64);
            tiles.push(Tile { name: "runs of a grid", value: grid.to_string(), remark: format!("as fine; this took {share} % of them") });
        }
        tiles
    }

    fn maps(&self, axes: [&DrawnAxis; 2], page: &mut Page, drawings: &mut Vec<(String, String)>) {
        let panels = panels(&self.sweep.file);
        let several = panels.len() > 1;
        for (i, panel) in panels.iter().take(MOST_PANELS).enumerate() {
            let map = Map::new(self.sweep, self.table, &self.drawn, axes, panel);
            let suffix = if several { format!("-{}", i + 1) } else { String::new() };
            let caption = "Each cell is a variant. The solid line is where linear theory puts the limit of stability in contact for the loop as \
                it is sampled, the dashed one for continuous control. Hover to see a variant and the command that runs it; click to copy it.";
            let title = if map.title.is_empty() { "Outcome".into() } else { format!("Outcome, {}.", map.title) };
            let svg = map.svg(&Colouring::Outcome(&self.outcomes));
            page.map(&title, caption, &svg, self.hover(&map.places()));
            drawings.push((format!("map{suffix}"), svg));
            let amplitudes = self.table.reals("amplitude_n").unwrap_or_default();
            let oscillates = map.rows().any(|row| amplitudes.get(row).copied().flatten().is_some_and(|a| a > 0.0));
            let (values, name, caption) = if oscillates {
                (amplitudes, "amplitude", "Half of peak to peak of the force of what lasts to the end.")
            } else {
                (self.table.reals("peak_force_n").unwrap_or_default(), "peak force", "The largest contact force of each variant.")
            };
            if values.len() == self.table.rows {
                let svg = map.svg(&Colouring::Measure(&values, name, "N"));
                page.map(if oscillates { "Size of the oscillation." } else { "Peak force." }, caption, &svg, self.hover(&map.places()));
                drawings.push((format!("size{suffix}"), svg));
            }
        }
        if panels.len() > MOST_PANELS {
            page.paragraph(&format!("{MOST_PANELS} of {} combinations are drawn; sweep.parquet has all.", panels.len()));
        }
    }

    fn diagrams(&self, axis: &DrawnAxis, page: &mut Page, drawings: &mut Vec<(String, String)>) {
        let diagram = Diagram::new(axis, self.table, (0..self.table.rows).collect());
        let theory = Theory::new(self, axis);
        let mut draw = |name: &str, title: &str, caption: &str, label: &str, lists: &[Vec<f64>], predictions: &[Prediction]| {
            let svg = diagram.svg(lists, &self.outcomes, label, predictions);
            page.map(title, caption, &svg, self.hover(&diagram.places()));
            drawings.push((name.into(), svg));
        };
        if let Some(lists) = self.table.lists("impact_peaks_n") {
            let caption = "The largest force of each of the last contacts: one point where they are alike, two where the period has doubled, many \
                where no two are alike, none where the tool stays in contact. The line is the cycle that describing functions predict, dashed \
                where it does not attract: the largest disturbance from which the loop settles.";
            draw("impacts", "Per impact.", caption, "peak force of an impact (N)", lists, &theory.peaks());
        }
        if let Some(lists) = self.table.lists("strobe_n") {
            let caption = "The force once per mean cycle, which is a point where every cycle is like the last.";
            draw("strobe", "Stroboscopic.", caption, "force once per cycle (N)", lists, &[]);
        }
        let amplitudes: Vec<Vec<f64>> =
            self.table.reals("amplitude_n").unwrap_or_default().iter().map(|value| value.iter().copied().collect()).collect();
        if amplitudes.len() == self.table.rows {
            draw(
                "amplitude",
                "Size of the oscillation.",
                "Half of peak to peak of the force of what lasts.",
                "amplitude (N)",
                &amplitudes,
                &[],
            );
        }
        theory.compare(page);
    }

    /// What the pointer shows at each place.
    fn hover(&self, places: &[[f64; 5]]) -> Value {
        // The page holds the rows of these places only, in their order.
        let rows: Vec<usize> = places.iter().map(|place| place[4] as usize).collect();
        let places: Vec<[f64; 5]> =
            places.iter().enumerate().map(|(i, &[x, y, width, height, _])| [x, y, width, height, i as f64]).collect();
        let of_reals = |key: &str| self.table.reals(key).map(|values| rows.iter().map(|&row| values[row]).collect::<Vec<Option<f64>>>());
        let mut columns: Vec<Value> = Vec::new();
        let mut settings: Vec<Value> = Vec::new();
        for (key, _) in &self.sweep.file.axes {
            let values = match self.table.columns.get(key) {
                Some(Column::Text(texts)) => json!(rows.iter().map(|&row| &texts[row]).collect::<Vec<_>>()),
                _ => json!(of_reals(key).unwrap_or_default()),
            };
            columns.push(json!([key, values, feeler_scenarios::format::unit_of_key(key)]));
            settings.push(json!([key, values]));
        }
        let label = |name: &String| {
            let known = Outcome::ALL.iter().find(|(_, known)| known == name);
            let otherwise = if name == "done" { "done" } else { "failed" };
            known.map_or_else(|| otherwise.to_owned(), |(outcome, _)| words::outcome_label(*outcome).to_owned())
        };
        columns.push(json!(["", rows.iter().map(|&row| label(&self.outcomes[row])).collect::<Vec<_>>(), ""]));
        for (name, unit) in SHOWN {
            let short = |v: Option<f64>| v.and_then(|v| format!("{v:.4e}").parse::<f64>().ok());
            if let Some(values) = of_reals(name) {
                let values: Vec<Option<f64>> = values.into_iter().map(short).collect();
                let words = name.rsplit_once('_').map_or(name, |(words, _)| words).replace('_', " ");
                columns.push(json!([words, values, unit]));
            }
        }
        json!({
            "places": places,
            "columns": columns,
            "settings": settings,
            "command": format!("feeler run {}", self.sweep.file.scenario.display()),
        })
    }

    fn counts(&self, page: &mut Page) {
        page.heading("Outcomes");
        let mut rows: Vec<Vec<String>> = Vec::new();
        for (outcome, name) in Outcome::ALL {
            let count = self.tally.count(name);
            if count > 0 {
                rows.push(vec![words::outcome_label(outcome).into(), count.to_string(), colour_name(name).into()]);
            }
        }
        let other = [("error", "failed"), ("done", "outcome not kept")].map(|(name, words)| (self.tally.count(name), words));
        for (count, words) in other.into_iter().filter(|(count, _)| *count > 0) {
            rows.push(vec![words.into(), count.to_string(), "black".into()]);
        }
        page.table(&["outcome", "variants", "colour"], &[1], &rows);
        if let Some((row, error)) = &self.tally.first_error {
            page.paragraph(&format!("The first to fail is variant {row}: {error}"));
        }
    }
}

fn colour_name(outcome: &str) -> &'static str {
    match palette::of_outcome(outcome) {
        "#0072b2" => "dark blue",
        "#56b4e9" => "sky blue",
        "#a6d8f5" => "pale blue",
        "#e69f00" => "orange",
        "#d55e00" => "vermilion",
        "#cc79a7" => "pink",
        "#f0e442" => "yellow",
        "#009e73" => "green",
        "#dddddd" => "light grey",
        "#999999" => "grey",
        _ => "black",
    }
}
