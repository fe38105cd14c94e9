//! `feeler why`.

use std::sync::Mutex;

use feeler_files::Draft;
use feeler_studies::why::{Change, Explanation, explain};

use crate::arguments::Why;
use crate::pages::why::{others, remedy_rows, trial_rows};
use crate::terminal::progress::Progress;
use crate::terminal::table;
use crate::units::Units;
use crate::{pages, terminal};

/// What the last column of the table of runs is.
const ABOUT_LIMIT: &str =
    " limit/gain: the sampled loop in contact is stable up to so many times its gain, by linear theory";
const ABOUT_NO_LIMIT: &str = " -: up to 50 times it at least, or linear theory has no answer";

pub(crate) fn run(arguments: &Why) -> crate::Result<()> {
    let document = Draft::load_with(&arguments.file, &arguments.settings)?.build()?;
    let progress = Mutex::new(Progress::new(document.scenario.machine.name.clone()));
    let expected = (Change::ALL.len() + 1) as f64;
    let found = explain(&document.scenario, &|runs| {
        if let Ok(mut progress) = progress.lock() {
            // Pairs and triples, where it takes them, come on top.
            progress.at((runs as f64 / expected).min(0.99));
        }
    })?;
    if let Ok(progress) = progress.into_inner() {
        progress.done();
    }
    let json = terminal::json(&found)?;
    let mut written = String::new();
    if let Some(folder) = &arguments.out {
        let page = pages::why::page(&document, &arguments.settings, &found);
        written = terminal::write_all(folder, &[("why.json", json.clone() + "\n"), ("report.html", page)])?;
    }
    if arguments.json {
        return terminal::print(&json);
    }
    let units = Units::of(&document.scenario.machine);
    terminal::print(&format!("{}{}{written}", found.verdict, details(&found, units)))
}

fn details(found: &Explanation, units: Units) -> String {
    if !found.chatters {
        return String::new();
    }
    let trials = table(
        &["the scenario with", "ends as", "amplitude", "limit/gain"],
        &[2, 3],
        trial_rows(found, units),
    );
    let others = match others(found) {
        rows if rows.is_empty() => String::new(),
        rows => format!("\n\n{}", table(&["as small, and removes it too", "takes away"], &[], rows)),
    };
    let all = std::iter::once(&found.baseline).chain(&found.singles);
    let unlimited = if all.clone().any(|trial| trial.applies && trial.gain_margin.is_none()) {
        format!("\n{ABOUT_NO_LIMIT}")
    } else {
        String::new()
    };
    let remedies = remedy_rows(found);
    let remedies = if remedies.is_empty() {
        "no remedy tried settles".into()
    } else {
        table(&["remedies, cheapest first", "gain kept", "bandwidth", "cost"], &[1, 2, 3], remedies)
    };
    format!("\n\n{trials}\n{ABOUT_LIMIT}{unlimited}{others}\n\n{remedies}")
}
