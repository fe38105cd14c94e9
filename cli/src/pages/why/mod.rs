//! The page of an explanation.

mod rows;

use feeler_files::Document;
use feeler_studies::run::Outcome;
use feeler_studies::why::{Explanation, Trial};

use crate::pages::parts::Page;
use crate::units::Units;

use rows::amplitude;
pub(crate) use rows::{LIFTS, lift_rows, others, remedy_rows, setting_rows, trial_rows, untried};

pub(crate) fn page(document: &Document, settings: &[String], found: &Explanation) -> String {
    let machine = &document.scenario.machine;
    let units = Units::of(machine);
    let title = if found.chatters { "causes of chatter, and remedies" } else { "what limits the gain" };
    let mut page = Page::new(&format!("{}: {title}", machine.name), &machine.about);
    page.lead(&found.verdict);
    let lifts = lift_rows(found);
    if !lifts.is_empty() {
        page.heading("What would lift the limit");
        page.paragraph(
            "Each row makes one property ideal. The limit is that of the sampled loop over its \
             gain, by linear theory. `feeler tune FILE` finds gains for the largest bandwidth.",
        );
        page.table(&LIFTS, &[1, 2], &lifts);
    }
    if found.chatters {
        page.heading("What to do");
        let rows = remedy_rows(found);
        if rows.is_empty() {
            page.paragraph("None of the remedies tried settles in simulation.");
        } else {
            page.paragraph(
                "Remedies that settle in simulation, the largest bandwidth first. Each keeps the gain, or \
                 reduces it to half of its stability limit. The last column compares with the bandwidth of \
                 the file's loop. If that loop is unstable, its bandwidth is theoretical.",
            );
            page.table(&["remedy", "gain kept", "bandwidth", "than now"], &[1, 2, 3], &rows);
            page.paragraph(
                "To apply one: these settings of `feeler run`, or `feeler why FILE --try N --out FILE`.",
            );
            page.table(&["remedy", "settings"], &[], &setting_rows(found));
        }
        page.heading("What was tried");
        page.paragraph(
            "Each row repeats the run with one property made ideal, or several if one is not enough. The \
             last column is the stability limit of the sampled loop over its gain, by linear \
             theory. A dash: 50 or more, or linear theory has no answer.",
        );
        page.table(&["with", "ends as", "amplitude", "limit over gain"], &[2, 3], &trial_rows(found, units));
        if let Some(said) = untried(found) {
            page.paragraph(&said);
        }
        let others = others(found);
        if !others.is_empty() {
            page.paragraph("These sets are as small and also remove the chatter:");
            page.table(&["with", "which removes"], &[], &others);
        }
        page.heading("What remains");
        page.paragraph("Amplitude of the contact force at the end of each run (logarithmic bars).");
        let bars = bars(found, units);
        page.bars(&bars);
    }
    page.heading("Scenario");
    if !settings.is_empty() {
        page.paragraph(&format!("Set on the command line: {}", settings.join("; ")));
    }
    page.verbatim("the file as it was run", document.text());
    page.render()
}

/// A bar for each run: its name, its length, and the amplitude as text.
fn bars(found: &Explanation, units: Units) -> Vec<(String, f64, String)> {
    let trials: Vec<&Trial> =
        std::iter::once(&found.baseline).chain(&found.singles).filter(|trial| trial.applies).collect();
    let length =
        |trial: &Trial| if trial.cured { 0.0 } else { trial.amplitude_n.unwrap_or(0.0).max(0.0).ln_1p() };
    let grows = |trial: &Trial| trial.outcome == Some(Outcome::Unstable);
    // Unbounded growth gets the longest bar.
    let longest = trials.iter().filter(|trial| !grows(trial)).map(|trial| length(trial)).fold(1.0, f64::max);
    let bar = |trial: &&Trial| {
        let name = trial.changes.first().map_or("everything as it is", |change| change.words()).to_owned();
        let said = if trial.only_by_period {
            "grows, less with the period".into()
        } else if trial.cured {
            "settles".into()
        } else {
            amplitude(trial, units).unwrap_or_else(|| "-".into())
        };
        (name, if grows(trial) { 1.1 * longest } else { length(trial) }, said)
    };
    trials.iter().map(bar).collect()
}
