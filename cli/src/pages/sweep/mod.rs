//! The page of a sweep: maps over two axes, diagrams over one, and the results of each variant.

mod answer;
mod bifurcation;
mod cycles;
mod decides;
mod drawn;
mod hover;
mod located;
mod map;
mod nearest;
mod palette;
mod periods;
mod png;
mod report;
mod tally;

use palette::labels;
pub(crate) use palette::of_outcome;
use std::cmp::Reverse;
use std::path::{Path, PathBuf};

use feeler_files::Setting;
use feeler_studies::run::{Outcome, controlled};
use feeler_studies::sweep::{CyclesAt, DrawnAxis, MapTheory, Panels, Sweep, SweepTable, Theory};

use bifurcation::{Diagram, Prediction};
use cycles::Predicted;
use drawn::Drawn;
pub(crate) use drawn::MOST_PANELS;
pub(crate) use located::{about_noise, located};
use map::{Colouring, Map};
use report::Report;
pub(crate) use tally::Tally;

use crate::numbers::{count, percent, plain};
use crate::pages::parts::{Page, Tile};
use crate::terminal;
use crate::units::Units;
use crate::words::judged_unit;

/// Largest number of panels that the first sentences of a page summarise.
const MOST_ANSWERS: u64 = 4;

/// Columns of lists, which only diagrams show.
const TAILS: [&str; 2] = ["impact_peaks_n", "strobe_n"];

/// Captions of bifurcation diagrams.
const PEAKS: &str = "The largest force of each of the last contacts. One point: all are alike. Two: the \
                     period has doubled. Many: no two are alike. No point: the tool stays in contact.";
const STROBE: &str = "The force one sample of the controller after each touch-down, which grows with the \
                      speed of impact. If the tool stays in contact, or a motion is judged: the largest \
                      value of each cycle. One point: every cycle is like the last. Two: the period has \
                      doubled.";

/// The variants of a sweep that its page draws.
pub(crate) struct Shown {
    drawn: Drawn,
    /// The rows of these variants.
    pub(crate) table: SweepTable,
}

/// Reads the drawn variants from the results in `path`.
pub(crate) fn read(sweep: &Sweep, path: &Path, tally: &Tally) -> crate::Result<Shown> {
    let axes = DrawnAxis::of(&sweep.file);
    let drawn = Drawn::of(&sweep.file, tally.rows);
    let is_shown = |column: &str| {
        let tail = axes.len() == 1 && TAILS.contains(&column);
        tail || ["outcome", "error"].contains(&column)
            || sweep.file.axes.contains_key(column)
            || hover::SHOWN.iter().any(|(name, ..)| *name == column)
    };
    let table = SweepTable::read_part(path, &is_shown, &|row| drawn.has(row))?;
    Ok(Shown { drawn, table })
}

/// Writes the page and its drawings. Returns their paths, and the region in which variants settle if it is
/// known.
pub(crate) fn write(
    sweep: &Sweep,
    name: &str,
    Shown { drawn, table }: &Shown,
    theory: &Theory,
    tally: &Tally,
    folder: &Path,
) -> crate::Result<(Vec<PathBuf>, Option<String>)> {
    let axes = DrawnAxis::of(&sweep.file);
    let outcomes = tally::outcomes(table).map(str::to_owned).collect();
    let units = Units::of(&sweep.document.scenario.machine);
    let controlled = controlled(&sweep.document.scenario).map(|signal| signal.to_string());
    let unit = judged_unit(controlled.as_deref(), units);
    let judged = (if controlled.is_some() { "motion" } else { units.force_word() }, unit);
    let mut report = Report { sweep, table, tally, drawn, axes, outcomes, units, judged };
    let mut theory = theory.clone();
    let is_reordered = report.draw_what_decides(&mut theory);
    let answer = report.answer();
    let mut page = Page::new(name, &sweep.file.about);
    page.lead(&report.lead(answer.as_deref().unwrap_or_default()));
    page.tiles(&report.tiles());
    if is_reordered {
        page.paragraph("The drawings are over the two numbers that decide most.");
    }
    let mut drawings: Vec<(String, String)> = Vec::new();
    match (report.axes.as_slice(), &theory) {
        ([axis], Theory::Diagrams(cycles)) => report.diagrams(axis, cycles, &mut page, &mut drawings),
        ([x, y, ..], Theory::Maps(limits)) => report.maps([x, y], limits, &mut page, &mut drawings),
        _ => page.paragraph("No axis of this sweep is a range of numbers, so there is nothing to draw."),
    }
    report.what_decides(&mut page);
    report.counts(&mut page);
    page.heading("Scenario");
    page.verbatim("the file whose keys are varied", sweep.document.text());
    let mut written = Vec::new();
    let mut pixels: Vec<(&str, PathBuf)> = Vec::new();
    for (name, svg) in &drawings {
        let path = folder.join(format!("{name}.svg"));
        terminal::write(&path, svg.as_bytes())?;
        let png = path.with_extension("png");
        written.extend([path, png.clone()]);
        pixels.push((svg, png));
    }
    png::write(&pixels)?;
    let path = folder.join("report.html");
    terminal::write(&path, page.render().as_bytes())?;
    written.push(path);
    Ok((written, answer))
}

impl Report<'_> {
    /// The first sentences: the answer, and the shares of all outcomes.
    fn lead(&self, answer: &str) -> String {
        let rows = self.tally.rows;
        let thinned = if self.axes.is_empty() { String::new() } else { self.drawn.words(self.table.rows) };
        if !self.sweep.file.keep.outcome {
            return format!("{rows} variants have run; the sweep keeps no outcomes.{thinned}");
        }
        let of = |outcome: &(Outcome, &str)| self.tally.count(outcome.1);
        let stable: usize = Outcome::ALL.iter().filter(|(outcome, _)| outcome.is_stable()).map(of).sum();
        let share = |count: usize| percent(count as f64 / rows.max(1) as f64);
        // The most frequent outcomes other than settling; the table has all.
        let mut others: Vec<(usize, &str)> = Outcome::ALL
            .iter()
            .filter(|(outcome, _)| !outcome.is_stable())
            .map(|(outcome, name)| (self.tally.count(name), headline(*outcome)))
            .chain([(self.tally.count("error"), "failed")])
            .filter(|(count, _)| *count > 0)
            .collect();
        others.sort_by_key(|(count, _)| Reverse(*count));
        let words = |(count, words): (usize, &str)| format!("{} % {words}", share(count));
        let said: Vec<String> = std::iter::once((stable, "settle")).chain(others).map(words).collect();
        let edges =
            located(self.sweep).map_or_else(String::new, |found| format!(" Edges are located to {found}."));
        let noise = about_noise(self.sweep).map_or_else(String::new, |words| format!(" {words}"));
        format!("{answer}Of {rows} variants {}.{edges}{noise}{thinned}", said.join(", "))
    }

    /// The region in which variants come to rest, or the random number that decides.
    fn answer(&self) -> Option<String> {
        if !self.sweep.file.keep.outcome {
            return None;
        }
        if self.axes.len() > 1 && self.is_random() {
            return answer::decisive(&self.halves());
        }
        let panels = Panels::of(&self.sweep.file);
        match panels.count() {
            1 => self.edge(&(0..self.table.rows).collect::<Vec<_>>()),
            2..=MOST_ANSWERS => {
                let of = |panel: Vec<(String, Setting)>| {
                    let edge = self.edge(&self.table.rows_with(&panel))?;
                    Some(format!("With {}, {}", map::words(&panel), edge.replacen("It", "it", 1)))
                };
                Some(panels.settings().filter_map(of).collect::<String>()).filter(|all| !all.is_empty())
            }
            _ => None,
        }
    }

    /// The edge at which variants over one axis or two stop or begin to settle.
    fn edge(&self, rows: &[usize]) -> Option<String> {
        let values = |axis: &DrawnAxis| self.table.reals(&axis.key);
        let outcome = |row: usize| rests(&self.outcomes[row]);
        match self.axes.as_slice() {
            [axis] => {
                let at = values(axis)?;
                let points = rows.iter().map(|&row| Some((at[row]?, outcome(row)?)));
                located::edge(axis, points.collect::<Option<_>>()?)
            }
            [x, y, ..] => {
                let (across, up) = (values(x)?, values(y)?);
                let points = rows.iter().filter_map(|&row| Some(([across[row]?, up[row]?], outcome(row))));
                answer::over_two([x, y], &points.collect::<Vec<_>>())
            }
            [] => None,
        }
    }

    fn tiles(&self) -> Vec<Tile> {
        let tile = |name, value: String, remark: &str| Tile::new(name, value, remark);
        let mut tiles = vec![tile("variants", self.tally.rows.to_string(), "")];
        if let Some(largest_n) = self.tally.largest_peak_n {
            tiles.push(tile(
                "largest peak",
                format!("{} {}", plain(largest_n), self.units.force),
                "of the contact, of any variant",
            ));
        }
        if self.sweep.file.keep.outcome {
            tiles.push(tile(
                "undecided",
                self.tally.count("undecided").to_string(),
                "at the end of the extended run",
            ));
        }
        tiles.push(tile("failed", self.tally.count("error").to_string(), "their rows have the error"));
        if let Some(grid) = self.sweep.runs_of_the_grid() {
            let share = percent(self.tally.rows as f64 / grid as f64);
            let remark = format!("of equal resolution; this took {share} % of them");
            tiles.push(Tile::new("runs of a grid", grid.to_string(), remark));
        }
        tiles
    }

    /// The drawn panels, each with the suffix for the names of its drawings. The page reports their number.
    fn panels(&self, page: &mut Page) -> Vec<(Vec<(String, Setting)>, String)> {
        let panels = Panels::of(&self.sweep.file);
        let count = panels.count();
        if count > MOST_PANELS as u64 {
            page.paragraph(&format!(
                "{MOST_PANELS} of {count} combinations are drawn; sweep.parquet has all."
            ));
        }
        let suffix = |i: usize| if count > 1 { format!("-{}", i + 1) } else { String::new() };
        panels.settings().take(MOST_PANELS).enumerate().map(|(i, panel)| (panel, suffix(i))).collect()
    }

    fn maps(
        &self,
        axes: [&DrawnAxis; 2],
        theory: &[MapTheory],
        page: &mut Page,
        drawings: &mut Vec<(String, String)>,
    ) {
        for (number, ((panel, suffix), theory)) in self.panels(page).into_iter().zip(theory).enumerate() {
            let map = Map::new(self.sweep, self.table, self.drawn, axes, &panel, theory);
            let caption = format!(
                "{} {} Hover to see a variant and the command that runs it; click to copy it. Draw a box to \
                 zoom, double-click to see the whole; keys: + − 0.",
                map.about_cells(),
                map.about_limits()
            );
            let plot = map.plot(&Colouring::Outcome(&self.outcomes));
            let mut hover = self.hover(&map.places());
            hover["fine"] = self.whole(axes, number);
            let first = page.plot(&titled("Outcome", &map.title), &caption, &plot, hover);
            drawings.push((format!("map{suffix}"), plot.with_legend()));
            let amplitudes = self.table.reals("amplitude_n").unwrap_or_default();
            let oscillates =
                map.rows().any(|row| amplitudes.get(row).copied().flatten().is_some_and(|a| a > 0.0));
            let (values, title, name, caption) = if oscillates {
                (
                    amplitudes,
                    "Size of the oscillation",
                    "amplitude",
                    &*format!("Half of the peak-to-peak {} that lasts to the end.", self.judged.0),
                )
            } else {
                (
                    self.table.reals("peak_force_n").unwrap_or_default(),
                    "Peak force",
                    "peak force",
                    "The largest contact force of each variant.",
                )
            };
            if values.len() == self.table.rows {
                let unit = if oscillates { self.judged.1 } else { self.units.force };
                let plot = map.plot(&Colouring::Measure(&values, name, unit));
                page.plot_like(&titled(title, &map.title), caption, &plot, first);
                drawings.push((format!("size{suffix}"), plot.with_legend()));
            }
        }
        if self.sweep.file.keep.outcome
            && Outcome::ALL.iter().any(|(outcome, name)| outcome.is_sustained() && self.tally.count(name) > 0)
        {
            page.paragraph(
                "Bifurcation diagrams (the peaks of impacts, and the force once per cycle) need a single \
                 axis of numbers. Leave the other out, or give it as a list of values. Each value then has \
                 its own diagrams.",
            );
        }
    }

    fn diagrams(
        &self,
        axis: &DrawnAxis,
        cycles: &[Vec<CyclesAt>],
        page: &mut Page,
        drawings: &mut Vec<(String, String)>,
    ) {
        for ((panel, suffix), cycles) in self.panels(page).into_iter().zip(cycles) {
            let rows = self.table.rows_with(&panel);
            let theory = Predicted::new(self, axis, cycles);
            let diagram = Diagram::new(axis, self.table, rows);
            let of_panel = map::words(&panel);
            let (force, unit) = self.judged;
            let mut first = None;
            let mut draw = |name: &str,
                            title: &str,
                            caption: &str,
                            label: &str,
                            lists: &[Vec<f64>],
                            predictions: &[Prediction]| {
                let is_empty = |row: &usize| lists[*row].iter().all(|value| value.abs() <= 0.0);
                if predictions.is_empty() && diagram.rows.iter().all(is_empty) {
                    page.paragraph(&format!(
                        "{} No variant here has any, so nothing is drawn.",
                        titled(title, &of_panel)
                    ));
                    return;
                }
                let svg = diagram.svg(lists, &self.outcomes, [label, unit], predictions);
                match first {
                    Some(first) => page.map_like(&titled(title, &of_panel), caption, &svg, first),
                    None => {
                        first = Some(page.map(
                            &titled(title, &of_panel),
                            caption,
                            &svg,
                            self.hover(&diagram.places()),
                        ));
                    }
                }
                drawings.push((format!("{name}{suffix}"), svg));
            };
            if let Some(lists) = self.table.lists("impact_peaks_n") {
                let leaves = diagram.rows.iter().any(|&row| !lists[row].is_empty());
                let predictions = if leaves { theory.peaks(|_| true) } else { Vec::new() };
                let about = about_predictions(&predictions, "the cycle that describing functions predict");
                draw(
                    "impacts",
                    "Per impact",
                    &format!("{PEAKS}{about}"),
                    &format!("peak {force} of an impact"),
                    lists,
                    &predictions,
                );
            }
            if let Some(lists) = self.table.lists("strobe_n") {
                let predictions = theory.peaks(|cycle| cycle.contact_share >= 1.0);
                let about = about_predictions(
                    &predictions,
                    "the largest force of the cycle in contact that describing functions predict",
                );
                draw(
                    "strobe",
                    "Stroboscopic",
                    &format!("{STROBE}{about}"),
                    &format!("{force} once per cycle"),
                    lists,
                    &predictions,
                );
            }
            let amplitudes = self.table.reals("amplitude_n").unwrap_or_default();
            let amplitudes: Vec<Vec<f64>> = amplitudes.iter().map(|a| a.iter().copied().collect()).collect();
            if amplitudes.len() == self.table.rows {
                let caption = format!("Half of the lasting peak-to-peak {force}.");
                draw("amplitude", "Size of the oscillation", &caption, "amplitude", &amplitudes, &[]);
            }
            self.periods(axis, &diagram.rows, &of_panel, page);
            theory.compare(&of_panel, page);
        }
    }

    fn counts(&self, page: &mut Page) {
        page.heading("Outcomes");
        let entry = |(name, label): (&str, &str)| {
            let variants = self.tally.count(name);
            (variants > 0)
                .then(|| (of_outcome(name), format!("{label}: {}", count(variants, "variant", "variants"))))
        };
        let entries: Vec<_> = labels().filter_map(entry).collect();
        page.swatches(&entries);
        if let Some((row, error)) = &self.tally.first_error {
            page.paragraph(&format!("The first failure is variant {row}: {error}"));
        }
    }
}

/// Whether an outcome is rest; `None` for a run that failed or is undecided.
fn rests(name: &str) -> Option<bool> {
    let known = Outcome::ALL.iter().find(|(_, own)| *own == name);
    known.filter(|(known, _)| *known != Outcome::Undecided).map(|(known, _)| known.is_stable())
}

/// Behaviour of variants that do not settle, as text after their number.
fn headline(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Chatter => "chatter",
        Outcome::Unstable => "are unstable",
        Outcome::LimitCycle => "oscillate between limits",
        Outcome::Hunting => "hunt",
        Outcome::Oscillates => "oscillate",
        Outcome::NoContact => "make no contact",
        _ => "are undecided",
    }
}

/// Meaning of the lines in a diagram, if there are any.
fn about_predictions(predictions: &[Prediction], what: &str) -> String {
    let [attracts, repels] =
        [false, true].map(|dashed| predictions.iter().any(|prediction| prediction.dashed == dashed));
    let repelling = "the largest disturbance from which the loop settles";
    match (attracts, repels) {
        (true, true) => format!(" The line is {what}, dashed where it does not attract: {repelling}."),
        (true, false) => format!(" The line is {what}."),
        (false, true) => format!(" The dashed line is {what}; it does not attract: {repelling}."),
        (false, false) => String::new(),
    }
}

/// A title with the name of its panel.
fn titled(title: &str, panel: &str) -> String {
    if panel.is_empty() { format!("{title}.") } else { format!("{title}, {panel}.") }
}
