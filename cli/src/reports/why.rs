//! The page of an explanation.

use feeler_scenarios::format::Document;
use feeler_scenarios::why::Explanation;

use crate::commands::why::{remedy_rows, trial_rows};
use crate::numbers::with_unit;
use crate::page::Page;

/// The page of an explanation.
pub(crate) fn page(document: &Document, settings: &[String], found: &Explanation) -> String {
    let machine = &document.scenario.machine;
    let mut page = Page::new(&format!("Why does {} chatter?", machine.name), &machine.about);
    page.lead(&found.verdict);
    if found.chatters {
        page.heading("What was tried");
        page.paragraph(
            "Each row is the scenario run again with one thing made ideal (or several, where it takes them). The last column is the factor on the \
             loop's gain up to which the sampled loop is stable in contact, by linear theory.",
        );
        page.table(&["with", "ends as", "amplitude", "limit over gain"], &[2, 3], &trial_rows(found));
        page.heading("What lasts");
        let bars: Vec<(String, f64, String)> = std::iter::once(&found.baseline)
            .chain(&found.singles)
            .filter(|trial| trial.applies)
            .map(|trial| {
                let name = trial.changes.first().map_or("everything as it is", |change| change.words()).to_owned();
                let amplitude = if trial.cured { 0.0 } else { trial.amplitude_n.unwrap_or(0.0) };
                // Sizes of motions that grow without bound say nothing; their bars show the order of magnitude at most.
                (name, amplitude.max(0.0).ln_1p(), if trial.cured { "settles".into() } else { with_unit(amplitude, "N") })
            })
            .collect();
        page.paragraph("Amplitude of the contact force that lasts to the end of each run (bars by logarithm).");
        page.bars(&bars);
        page.heading("What to do");
        let rows = remedy_rows(found);
        if rows.is_empty() {
            page.paragraph("None of the remedies tried settles in simulation.");
        } else {
            page.paragraph(
                "Remedies that settle in simulation, each with as much of the gain as half its largest stable one allows, cheapest in bandwidth first.",
            );
            page.table(&["remedy", "gain kept", "bandwidth", "cost in bandwidth"], &[1, 2, 3], &rows);
        }
    }
    page.heading("Scenario");
    if !settings.is_empty() {
        page.paragraph(&format!("Set on the command line: {}", settings.join("; ")));
    }
    page.verbatim("the file as it was run", document.text());
    page.render()
}
