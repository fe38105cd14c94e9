//! `feeler diagnose`.

use std::fmt::Write as _;
use std::path::Path;

use feeler_diagnosis::Examination;
use feeler_diagnosis::dataset::{Dataset, Record};
use feeler_diagnosis::report::Verdict;
use feeler_files::{Commands, DatasetFile, Document, driven_to_toml, machine_to_toml, samples_csv};

use crate::arguments::Diagnose;
use crate::numbers::{fine_percent, percent};
use crate::pages::diagnosis::advice::{Advice, Advised};
use crate::pages::diagnosis::{self, WITH_EFFECTS, words};
use crate::terminal::failure::{BadInput, Failure};
use crate::terminal::progress::Steps;
use crate::terminal::table;
use crate::{repaired, terminal};

/// Largest number of attempts on the terminal; the page has more.
const MOST_RIVALS: usize = 4;

pub(crate) fn run(arguments: &Diagnose) -> crate::Result<()> {
    let budget = arguments.budget.begin();
    let dataset = Dataset::load(&arguments.dataset)?.in_pieces();
    let folder =
        arguments.out.clone().unwrap_or_else(|| terminal::results::folder(&dataset.name, "diagnosis"));
    terminal::make_folder(&folder)?;
    let steps = Steps::new(format!("diagnosing {}", dataset.name));
    let answer = Examination::within(dataset, budget, &|what| steps.at(what));
    steps.done();
    let answer = answer?;
    let json = terminal::json(&Advised::of(&answer.diagnosis))? + "\n";
    let (machine, commands) = machine_file(&answer);
    let mut files = vec![
        ("diagnosis.json", json.clone()),
        ("report.html", diagnosis::page(&answer)),
        ("machine.toml", machine),
    ];
    files.extend(commands.iter().map(|(name, text)| (name.as_str(), text.clone())));
    if let Some(next) = &answer.diagnosis.next_experiment {
        files.push(("next-experiment.csv", samples_csv(next.spacing_s, &next.command)));
    }
    let written = terminal::write_all(&folder, &files)?;
    if arguments.json {
        return terminal::print(&json);
    }
    let mut said = summary(&answer);
    if arguments.changes {
        let _ = write!(said, "\n\n{}", change(&answer));
    }
    let refused = not_applicable(
        answer.diagnosis.verdict,
        !answer.diagnosis.contradictions.is_empty(),
        answer.diagnosis.adequacy.has_untried(),
    );
    if let (true, None) = (arguments.apply, refused) {
        let _ = write!(said, "\n\n{}", apply(&arguments.dataset, &answer)?);
    }
    terminal::print(&format!("{said}{written}"))?;
    if let (true, Some([why, remedy])) = (arguments.apply, refused) {
        terminal::complain(&format!("not applied: {why}\n  help: {remedy}"));
        return Err(Failure::CheckFailed);
    }
    Ok(())
}

/// The most important results for an engineer.
fn summary(answer: &Examination) -> String {
    let diagnosis = &answer.diagnosis;
    let gap = &diagnosis.gap;
    let mut said = format!("{}: {}\n", answer.dataset.name, words::verdict(diagnosis));
    let row = |name: &str, value: f64| vec![name.to_owned(), fine_percent(value), "%".into()];
    let mut gaps = vec![row("gap, machine as given", gap.before), row("after calibration", gap.refit)];
    if words::is_found(diagnosis) {
        gaps.push(row(WITH_EFFECTS, gap.after));
    }
    gaps.push(row("noise floor", gap.floor));
    let _ = write!(said, "\n{}\n{}\n", table(&[], &[1], gaps), words::closed(diagnosis, answer.checks()));
    if !diagnosis.places.is_empty() {
        let rows = diagnosis.places.iter().map(|place| {
            let band = words::band(place.band_hz);
            vec![
                place.place.to_owned(),
                format!("{} %", percent(place.probability)),
                format!("{}, {band}, {}", place.channel, place.phase),
            ]
        });
        let _ = write!(said, "\n{}\n", table(&["where", "probability", "shows most in"], &[1], rows));
    }
    if !diagnosis.effects.is_empty() {
        let shown = diagnosis.effects.iter().filter(|effect| effect.accepted).count() + MOST_RIVALS;
        let rows = diagnosis.effects.iter().take(shown).map(|effect| {
            let status = if effect.accepted { "found" } else { "rival" };
            let (kind, on) = (effect.kind.to_string(), effect.on.clone());
            vec![
                status.into(),
                kind,
                on,
                format!("{} %", percent(effect.probability)),
                words::parameters(effect),
            ]
        });
        let _ = write!(
            said,
            "\n{}\n",
            table(&["", "cause", "on", "probability", "parameters (90 %)"], &[3], rows)
        );
    }
    let advice = Advice::of(diagnosis);
    said.push_str("\nWhat to do");
    for (i, step) in advice.steps.iter().enumerate() {
        let _ = write!(said, "\n  {}. {step}", i + 1);
    }
    if !advice.remarks.is_empty() {
        said.push('\n');
    }
    for remark in &advice.remarks {
        let _ = write!(said, "\n{remark}");
    }
    for warning in &diagnosis.warnings {
        let _ = write!(said, "\nwarning: {warning}");
    }
    said.trim_end().to_owned()
}

/// The changes to the believed machine, as text.
fn change(answer: &Examination) -> String {
    if answer.difference.is_empty() {
        return nothing_to_change("the machine", answer);
    }
    format!("# changes to the believed machine\n{}", answer.difference.to_string().trim_end())
}

fn nothing_to_change(what: &str, answer: &Examination) -> String {
    let is_early = answer.diagnosis.adequacy.has_untried();
    let so_far = if is_early { " so far: the time ended before all causes were tried" } else { "" };
    format!("nothing to change in {what}{so_far}")
}

/// Changes the machine file of a dataset. Reports the path of the copy of the old file.
fn apply(dataset: &Path, answer: &Examination) -> crate::Result<String> {
    let path = DatasetFile::load(dataset)?.machine_path;
    if answer.difference.is_empty() {
        return Ok(nothing_to_change(&path.display().to_string(), answer));
    }
    let text = Document::load(&path)?.edited(&repaired::edits(answer))?;
    let backup = terminal::rewrite(&path, &text).map_err(|error| BadInput::unwritable(&path, &error))?;
    let mut said = format!("changed {}; the old file is {}", path.display(), backup.display());
    if answer.diagnosis.adequacy.has_doubtful_value() {
        said.push_str("; a doubtful value is among the changes, see above");
    } else if matches!(answer.diagnosis.verdict, Verdict::Ambiguous | Verdict::NotIdentifiable) {
        said.push_str("; other changes would fit these records as well, see above");
    }
    for removed in &answer.difference.removed {
        let _ = write!(said, "\nremove [{removed}] by hand: an effect that was found replaces it");
    }
    Ok(said)
}

/// Reason why the machine file should not be changed; `None` if it may be.
fn not_applicable(verdict: Verdict, is_contradictory: bool, has_untried: bool) -> Option<[&'static str; 2]> {
    match verdict {
        _ if is_contradictory => {
            Some(["these records contradict each other", "correct them first, then diagnose again"])
        }
        Verdict::UnknownCause if has_untried => Some([
            "the time ended before all causes were tried to the end, and more than noise is left",
            "diagnose again with a larger --budget; `--changes` prints what comes nearest so far",
        ]),
        Verdict::UnknownCause => Some([
            "no value within its tolerance removes the gap: the real cause is another",
            "inspect the place named above; `--changes` prints what comes nearest",
        ]),
        _ => None,
    }
}

/// A file of the repaired machine with the commands of a check experiment, ready to run: its text, and the
/// names and texts of the files that it reads.
fn machine_file(answer: &Examination) -> (String, Vec<(String, String)>) {
    let (dataset, machine) = (&answer.dataset, &answer.diagnosis.machine);
    let own = machine.contacts.values().next().map(|contact| contact.engagement);
    let is_own = |record: &&Record| {
        record.is_check && record.engagement.is_none_or(|engagement| Some(engagement) == own)
    };
    let shown = dataset.records.iter().find(is_own).or(dataset.records.iter().find(|record| record.is_check));
    let Some(record) = shown.or(dataset.records.first()) else {
        return (repaired::with_rounded(machine_to_toml(machine), answer), Vec::new());
    };
    let columns = dataset.drives.iter().zip(&record.commands);
    let (text, files) = driven_to_toml(
        machine,
        &Commands {
            experiment: &record.name,
            spacing_s: record.spacing_s,
            columns: columns
                .map(|(driven, values)| (driven.drive, driven.column.as_str(), &values[..]))
                .collect(),
        },
    );
    (repaired::with_rounded(text, answer), files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_what_no_value_removes_is_not_applied() {
        let is_applied =
            |verdict, is_contradictory| not_applicable(verdict, is_contradictory, false).is_none();
        assert!(is_applied(Verdict::Explained, false) && is_applied(Verdict::NoGap, false));
        assert!(is_applied(Verdict::Ambiguous, false));
        assert!(!is_applied(Verdict::UnknownCause, false) && !is_applied(Verdict::Explained, true));
        // If the time was too short to try all causes, the remedy is a larger budget.
        let [cut, tried] = [true, false].map(|cut| not_applicable(Verdict::UnknownCause, false, cut));
        assert!(cut.is_some_and(|[_, remedy]| remedy.contains("--budget")) && cut != tried);
    }
}
