//! The page of one run.

mod charts;

use std::fmt::Write as _;

use feeler_files::Document;
use feeler_problem::Problem;
use feeler_studies::Doubts;
use feeler_studies::run::{EnergyItem, EnergyTable, EventRecord, Outcome, RunResult, Summary};

use charts::View;

use crate::numbers::{count, percent, plain, split, with_unit};
use crate::pages::parts::{Chart, Page, Tile, Tone};
use crate::units::Units;
use crate::words;

/// Largest number of listed events; the summary has all.
const MOST_EVENTS: usize = 400;
/// Overshoot, as a share of the reference, above which the tile is marked as bad.
const MUCH_OVERSHOOT: f64 = 0.5;

pub(crate) fn page(document: &Document, settings: &[String], result: &RunResult, doubts: &Doubts) -> String {
    let summary = &result.summary;
    let machine = &document.scenario.machine;
    let mut about = machine.about.clone();
    if !settings.is_empty() {
        let _ = write!(about, " Set on the command line: {}", settings.join("; "));
    }
    let mut page = Page::new(&machine.name, about.trim_start());
    let units = Units::of(machine);
    let words::Account { sentences, doubt } = words::account(&document.scenario, summary, units, doubts);
    page.lead(&sentences[0]);
    sentences[1..].iter().for_each(|sentence| page.paragraph(sentence));
    for Problem { key, message, remedy } in doubts.all.iter().filter(|other| Some(*other) != doubt) {
        page.paragraph(&format!("Doubtful in the file: {key}: {message}; {remedy}."));
    }
    page.tiles(&tiles(summary, units, strongest_hz(result)));
    let view = View::new(document, result, units);
    // The most important charts come first: the force over the whole run, then a close-up of an oscillation.
    view.whole_run(&mut page);
    view.surface(&mut page);
    view.close_up(&mut page);
    view.phase_portrait(&mut page);
    view.spectrum(&mut page);
    view.motion(&mut page);
    if let Some(table) = &summary.energy {
        energy(&mut page, table);
    }
    events(&mut page, summary);
    view.others(&mut page);
    page.heading("Scenario");
    page.verbatim("the file as it was run", document.text());
    page.render()
}

/// Frequency of the strongest line of a growing force, Hz. The summary has that of a sustained oscillation.
fn strongest_hz(result: &RunResult) -> Option<f64> {
    let grows = result.summary.outcome == Outcome::Unstable && result.summary.oscillation.is_none();
    let spectrum = result.tail_spectrum().filter(|_| grows)?;
    let lines =
        spectrum.frequencies_hz.iter().zip(&spectrum.amplitudes).filter(|(frequency, _)| **frequency > 0.0);
    lines.max_by(|a, b| a.1.total_cmp(b.1)).map(|(frequency, _)| *frequency)
}

/// The first charts of a run, for a live page.
pub(crate) fn overview(document: &Document, result: &RunResult) -> Vec<Chart> {
    View::new(document, result, Units::of(&document.scenario.machine)).overview()
}

pub(crate) fn tiles(summary: &Summary, units: Units, strongest_hz: Option<f64>) -> Vec<Tile> {
    let tile = |name, value: String, remark: String| Tile::new(name, value, remark);
    let outcome = Tile::new("outcome", words::label(summary), "").toned(tone(summary.outcome));
    let mut tiles = vec![outcome];
    let hardest = summary.contacts.iter().max_by(|a, b| a.peak_force_n.total_cmp(&b.peak_force_n));
    if let Some(contact) = hardest {
        tiles.push(tile("peak force", with_unit(contact.peak_force_n, units.force), words::when(contact)));
    }
    if let Some(response) = summary.response {
        let of = words::overshoot_of(summary, units);
        let share = response.overshoot;
        let much = share.is_some_and(|share| share > MUCH_OVERSHOOT);
        let overshoot = share.map_or("-".into(), |share| format!("{} %", percent(share)));
        let tone = if much { Tone::Bad } else { Tone::Plain };
        tiles.push(Tile::new("overshoot", overshoot, of).toned(tone));
        if let Some((largest, remark)) = words::tracking(summary, units) {
            tiles.push(tile("tracking error", with_unit(largest, units.force), remark));
        } else {
            let outside = words::rests_outside(summary, units);
            let absent = if outside.is_some() { "-" } else { "not settled" };
            let time = response.settling_time_s.map_or(absent.into(), |time| with_unit(time, "s"));
            let band =
                outside.unwrap_or_else(|| format!("to within {}", with_unit(response.band_n, units.force)));
            tiles.push(tile("settling time", time, band));
        }
    }
    if !summary.contacts.is_empty() {
        tiles.push(tile("bounces", summary.bounces.to_string(), "times the tool left the workpiece".into()));
        let share = format!("{} % of the run", percent(summary.contact_share));
        tiles.push(tile("contact time", with_unit(summary.contact_time_s, "s"), share));
    }
    if let Some(oscillation) = &summary.oscillation {
        let impacts = format!("{} impacts per second", plain(oscillation.impacts_per_s));
        tiles.push(tile("frequency", with_unit(oscillation.frequency_hz, "Hz"), impacts));
        tiles.push(tile(
            "amplitude",
            with_unit(oscillation.amplitude_n, words::judged_unit(summary.controlled.as_deref(), units)),
            "half of peak to peak".into(),
        ));
    }
    if let Some(frequency_hz) = strongest_hz {
        tiles.push(tile("frequency", with_unit(frequency_hz, "Hz"), "of the growing motion".into()));
    }
    tiles.push(tile(
        "saturation",
        format!("{} %", percent(summary.saturation_share)),
        "of the controller samples".into(),
    ));
    if let Some(energy) = &summary.energy {
        let closes =
            Tile::new("energy balance", plain(energy.relative_residual), "residual over energy exchanged");
        tiles.push(closes.toned(Tone::Quiet));
    }
    tiles
}

/// Assessment of an outcome.
pub(crate) fn tone(outcome: Outcome) -> Tone {
    match outcome {
        Outcome::Settled => Tone::Good,
        outcome if outcome.is_sustained() || outcome == Outcome::Unstable => Tone::Bad,
        _ => Tone::Plain,
    }
}

fn energy(page: &mut Page, energy: &EnergyTable) {
    page.heading("Energy");
    page.paragraph(
        "Energy that each element supplied (blue) and removed (orange). Energy stored at the end counts as \
         removed.",
    );
    let bar = |sign: f64| {
        move |item: &EnergyItem| {
            (
                // Links between bodies are called `springs` in the file.
                format!("{}, {}", item.what.replace("link", "spring").replace('-', " "), item.on),
                sign * item.joule,
                with_unit(sign * item.joule, "J"),
            )
        }
    };
    let growth =
        |name: &str, [first, last]: [f64; 2]| (name.to_owned(), first - last, with_unit(first - last, "J"));
    let moved = |item: &&EnergyItem| item.joule != 0.0;
    let bars: Vec<_> = (energy.supplied.iter().filter(moved).map(bar(1.0)))
        .chain(energy.dissipated.iter().filter(moved).map(bar(-1.0)))
        .chain([growth("stored, kinetic", energy.kinetic), growth("stored, elastic", energy.elastic)])
        .collect();
    page.bars(&bars);
    let row = |item: &EnergyItem| {
        vec![item.what.replace('-', " "), item.on.clone(), split(item.joule, "J").0, split(item.joule, "J").1]
    };
    let controllers: Vec<Vec<String>> = energy.controllers.iter().map(row).collect();
    if !controllers.is_empty() {
        page.table(&["part of it", "by", "energy", "unit"], &[2], &controllers);
    }
    page.paragraph(&format!(
        "Energy balance: of {} exchanged, {} is unaccounted for (error {}).",
        with_unit(energy.exchanged, "J"),
        with_unit(energy.residual.abs(), "J"),
        plain(energy.relative_residual)
    ));
}

fn events(page: &mut Page, summary: &Summary) {
    page.heading("Events");
    if summary.events.is_empty() {
        page.paragraph("No touch, lift, stick, slip or limit occurred.");
        return;
    }
    let rows = event_rows(&summary.events[..summary.events.len().min(MOST_EVENTS)]);
    let all = count(summary.events.len(), "event", "events");
    let title = if rows.len() < summary.events.len() {
        format!("the first {} of {all}; summary.json has all", rows.len())
    } else {
        all
    };
    page.folded_table(&title, &EVENTS, &[0], &rows);
}

/// Column titles of a list of events.
pub(crate) const EVENTS: [&str; 3] = ["time (s)", "what", "on"];

/// Events in rows, with their times to the microsecond.
pub(crate) fn event_rows(events: &[EventRecord]) -> Vec<Vec<String>> {
    let row =
        |event: &EventRecord| vec![format!("{:.6}", event.t_s), event.what.to_owned(), event.on.clone()];
    events.iter().map(row).collect()
}
