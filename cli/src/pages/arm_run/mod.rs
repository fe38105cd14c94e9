//! The page of one run of a whole arm.

mod charts;
mod scene;

use feeler_files::CellFile;
use feeler_studies::run::{CellRun, CellSummary};

use crate::numbers::{count, percent, plain, with_unit};
use crate::pages::parts::{Page, Tile};
use crate::pages::run::{EVENTS, event_rows, tone};
use crate::units::Units;
use crate::words;

/// Largest number of listed events; the summary has all.
const MOST_EVENTS: usize = 400;

/// The page of a run.
pub(crate) fn page(file: &CellFile, settings: &[String], result: &CellRun) -> crate::Result<String> {
    let units = Units::of(&file.cell.scenario.machine);
    let mut page = Page::new(&file.name, &file.about);
    page.lead(&format!("{}{}", words::outcome(&result.summary.figures, units), limits(&result.summary)));
    page.tiles(&tiles(result));
    page.heading("The arm");
    page.scene(
        "The arm as it moves.",
        "Drag to rotate, scroll to zoom. The thickness of a link follows from its inertia. The arrow is the \
         force on the tool.",
        scene::scene(file, result)?,
    );
    page.heading("The run");
    page.paragraph(
        "Drag across a chart to zoom, all charts follow; double-click to see the whole again. \
                    Shaded: in contact.",
    );
    charts::whole_run(&mut page, file, result);
    charts::close_up(&mut page, file, result);
    events(&mut page, result);
    page.heading("Scenario");
    if !settings.is_empty() {
        page.paragraph(&format!("Set on the command line: {}", settings.join("; ")));
    }
    page.paragraph(
        "Gravity is taken as compensated, links as rigid, the workpiece as fixed; tip and workpiece slide \
         on each other without friction.",
    );
    page.verbatim("the file as it was run", file.text());
    Ok(page.render())
}

/// Text on joints that reached the end of their travel; empty if there are none.
pub(crate) fn limits(summary: &CellSummary) -> String {
    let met = summary.limits.iter().map(|met| {
        let at = with_unit(met.t_s, "s");
        format!(
            " Warning: joint `{}` met its {} of {} at {at}; a stop as stiff as its gear held it there.",
            met.joint,
            met.what,
            plain(met.position)
        )
    });
    met.collect()
}

fn tiles(result: &CellRun) -> Vec<Tile> {
    let tile = |name, value: String, remark: String| Tile::new(name, value, remark);
    let summary = &result.summary;
    let figures = &summary.figures;
    let mut tiles = vec![
        Tile::new("outcome", words::label(figures), "").toned(tone(figures.outcome)),
        tile(
            "peak force",
            with_unit(figures.peak_force_n, "N"),
            format!("at {}", with_unit(result.contact.peak_at_s, "s")),
        ),
        tile("final force", with_unit(summary.final_force_n, "N"), "mean of the last tenth".into()),
    ];
    if let Some(response) = figures.response {
        let of = response
            .final_reference_n
            .map_or_else(String::new, |reference| format!("of {}", with_unit(reference, "N")));
        tiles.push(tile(
            "overshoot",
            response.overshoot.map_or("-".into(), |share| format!("{} %", percent(share))),
            of,
        ));
        let time = response.settling_time_s.map_or("not settled".into(), |time| with_unit(time, "s"));
        tiles.push(tile("settling time", time, format!("to within {}", with_unit(response.band_n, "N"))));
    }
    tiles.push(tile("bounces", figures.bounces.to_string(), "times the tool left the workpiece".into()));
    let share = format!("{} % of the run", percent(figures.contact_share));
    tiles.push(tile("contact time", with_unit(figures.contact_time_s, "s"), share));
    if let Some(oscillation) = &figures.oscillation {
        let impacts = format!("{} impacts per second", plain(oscillation.impacts_per_s));
        tiles.push(tile("chatter frequency", with_unit(oscillation.frequency_hz, "Hz"), impacts));
        tiles.push(tile(
            "chatter amplitude",
            with_unit(oscillation.amplitude_n, "N"),
            "half of peak to peak".into(),
        ));
    }
    tiles.push(tile("sideways", with_unit(summary.sideways_m, "m"), "largest sideways error".into()));
    let per_second = format!("{} per simulated second", with_unit(summary.wall_s_per_simulated_s, "s"));
    tiles.push(tile("time taken", with_unit(figures.wall_s, "s"), per_second));
    tiles
}

fn events(page: &mut Page, result: &CellRun) {
    let events = &result.summary.figures.events;
    if events.is_empty() {
        return;
    }
    page.heading("Events");
    let rows = event_rows(&events[..events.len().min(MOST_EVENTS)]);
    let all = count(events.len(), "event", "events");
    let title = if rows.len() < events.len() { format!("the first {} of {all}", rows.len()) } else { all };
    page.folded_table(&title, &EVENTS, &[0], &rows);
}
