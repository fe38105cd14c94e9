//! `feeler why`.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use feeler_files::{Document, Draft};
use feeler_studies::doubts;
use feeler_studies::why::{Counterfactual, Explanation, explain};

use crate::arguments::Why;
use crate::pages::why::{LIFTS, lift_rows, others, remedy_rows, setting_rows, trial_rows, untried};
use crate::terminal::failure::BadInput;
use crate::terminal::progress::Progress;
use crate::terminal::table;
use crate::units::Units;
use crate::{pages, terminal};

/// Meaning of the last column of the table of runs.
const ABOUT_LIMIT: &str = "limit/gain: stability limit of the sampled loop over its gain, by linear theory";
const ABOUT_NO_LIMIT: &str = "-: 50 or more, or linear theory has no answer";
/// Meaning of the last column of the table of remedies.
const ABOUT_NOW: &str =
    "than now: compared with the bandwidth of the file's loop; that of an unstable loop is theoretical";

pub(crate) fn run(arguments: &Why) -> crate::Result<()> {
    let document = Draft::load_with(&arguments.file, &arguments.settings)?.build()?;
    terminal::warn(&doubts(&document.scenario).all);
    let progress = Mutex::new(Progress::new(document.scenario.machine.name.clone()));
    let expected = (Counterfactual::ALL.len() + 1) as f64;
    let found = explain(&document.scenario, &|runs| {
        if let Ok(mut progress) = progress.lock() {
            // Pairs and triples are additional runs, if needed.
            progress.at((runs as f64 / expected).min(0.99));
        }
    })?;
    if let Ok(progress) = progress.into_inner() {
        progress.done();
    }
    if let Some(number) = arguments.remedy {
        return apply(arguments, &document, &found, number);
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
    let set = arguments.settings.iter().map(|setting| format!(" --set {}", terminal::quoted(setting)));
    let named = terminal::quoted_path(&arguments.file) + &set.collect::<String>();
    let cure =
        setting_rows(&found).first().map(|row| format!("why {named} --try {} --out cured.toml", row[0]));
    let next = if found.chatters { cure } else { Some(format!("tune {named}")) };
    let next = next.map(|next| format!("\n\nnext: feeler {next}"));
    let said = terminal::wrapped(&found.verdict) + &details(&found, units) + &written;
    terminal::print(&(said + &next.unwrap_or_default()))
}

/// Writes the file with a remedy and with the settings of the command line.
fn apply(arguments: &Why, document: &Document, found: &Explanation, number: usize) -> crate::Result<()> {
    let Some(out) = &arguments.out else { return Ok(()) };
    let settings = number.checked_sub(1).and_then(|i| found.remedies.get(i)).map(|remedy| &remedy.settings);
    let Some(settings) = settings.filter(|settings| !settings.is_empty()) else {
        let known: Vec<String> = setting_rows(found).into_iter().map(|mut row| row.swap_remove(0)).collect();
        return Err(BadInput::error(
            format!("{} has no remedy {number} that can be applied by settings", arguments.file.display()),
            if !found.chatters {
                "it does not chatter: `feeler tune FILE` raises its bandwidth".into()
            } else if known.is_empty() {
                "no remedy that was tried settles, as `feeler why FILE` shows".into()
            } else {
                format!("try one of {}", known.join(", "))
            },
        ));
    };
    let all: Vec<String> = arguments.settings.iter().chain(settings).cloned().collect();
    let written = write_set(&arguments.file, document, &all, out)?;
    let kept = kept(written.backup.as_deref());
    let next = next(&written.compared, out);
    terminal::print(&format!("{}: {}{kept}\n\n{next}", out.display(), settings.join("; ")))
}

/// Sentence on the copy of a replaced file; empty without a copy.
pub(super) fn kept(backup: Option<&Path>) -> String {
    backup.map_or_else(String::new, |backup| format!(" (what it was is in {})", backup.display()))
}

/// The command that compares a changed file with its original.
pub(super) fn next(file: &Path, out: &Path) -> String {
    format!("next: feeler compare {} {}", terminal::quoted_path(file), terminal::quoted_path(out))
}

/// A written file.
pub(super) struct WrittenSet {
    /// Copy of the file that was there.
    pub(super) backup: Option<PathBuf>,
    /// The file without the settings.
    pub(super) compared: PathBuf,
}

/// Writes a file with changed settings, and reads it back. Comments are kept. A copy gets the name of its
/// file, because `feeler run` writes into a folder of that name and must keep the results of the original. If
/// `out` exists, its old text is copied beside it.
pub(super) fn write_set(
    file: &Path,
    document: &Document,
    settings: &[String],
    out: &Path,
) -> crate::Result<WrittenSet> {
    let folder =
        |path: &Path| std::path::absolute(path).ok().and_then(|path| Some(path.parent()?.to_owned()));
    let from = folder(file).filter(|from| folder(out).as_ref() != Some(from));
    let is_copy = out.canonicalize().ok() != file.canonicalize().ok();
    let is_named = settings.iter().any(|setting| setting.starts_with("name="));
    let mut settings = settings.to_vec();
    if let Some(stem) = out.file_stem().filter(|_| is_copy && !is_named && document.place("name").is_some()) {
        settings.push(format!("name={:?}", stem.to_string_lossy()));
    }
    let text = document
        .with_settings(&settings, from.as_deref())
        .ok_or_else(|| crate::Failure::internal("the settings do not fit the file"))?;
    let backup = terminal::write_kept(out, &text)?;
    Draft::load(out)?.build()?;
    let compared = backup.clone().filter(|_| !is_copy).unwrap_or_else(|| file.to_owned());
    Ok(WrittenSet { backup, compared })
}

fn details(found: &Explanation, units: Units) -> String {
    if !found.chatters {
        let rows = lift_rows(found);
        return if rows.is_empty() { String::new() } else { format!("\n\n{}", table(&LIFTS, &[1, 2], rows)) };
    }
    let trials = table(
        &["the scenario with", "ends as", "amplitude", "limit/gain"],
        &[2, 3],
        trial_rows(found, units),
    );
    let untried = untried(found).map_or_else(String::new, |said| format!("\n{said}"));
    let others = match others(found) {
        rows if rows.is_empty() => String::new(),
        rows => {
            format!("\n\n{}", table(&["equally small change that also removes it", "ingredient"], &[], rows))
        }
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
        let settings = table(&["remedy", "applied by"], &[], setting_rows(found));
        let costs = table(
            &["remedies, largest bandwidth first", "gain kept", "bandwidth", "than now"],
            &[1, 2, 3],
            remedies,
        );
        format!("{costs}\n{}\n\n{settings}", terminal::wrapped(ABOUT_NOW))
    };
    let about = terminal::wrapped(&format!("{ABOUT_LIMIT}{unlimited}{untried}"));
    format!("\n\n{trials}\n{about}{others}\n\n{remedies}")
}
