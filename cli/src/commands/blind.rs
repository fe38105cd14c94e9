//! `feeler blind`.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use feeler_diagnosis::blind::{
    Answered, AnsweredEffect, CASES, Case, HELD_BACK, SEALED, make, make_servo, make_wild, regressions,
    score, unseal,
};
use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::replay::free_runs;
use feeler_diagnosis::report::Diagnosis;
use feeler_diagnosis::{DiagnosisError, closing, diagnose_within};
use feeler_plant::effects::find;

use crate::arguments::{Blind, BlindMake, BlindRun, BlindScore};
use crate::numbers::count;
use crate::pages::diagnosis::advice::Advised;
use crate::terminal::failure::BadInput;
use crate::terminal::progress::Rate;
use crate::terminal::table;
use crate::{pages, terminal};

/// Folder of the answers.
const ANSWERS: &str = "answers";
/// The file of an answer that is scored.
const ANSWER: &str = "answer.json";

pub(crate) fn run(arguments: &Blind) -> crate::Result<()> {
    match arguments {
        Blind::Make(arguments) => make_cases(arguments),
        Blind::Run(arguments) => run_cases(arguments),
        Blind::Score(arguments) => score_cases(arguments),
    }
}

fn make_cases(arguments: &BlindMake) -> crate::Result<()> {
    let folder = &arguments.out;
    terminal::make_folder(folder)?;
    let rate = Rate::new("making cases");
    let total = u64::from(arguments.cases);
    let (count_of_cases, seed) = (total as usize, arguments.seed);
    let progress = |done: usize| rate.at(done as u64, 0, total);
    let is_known = |kind: &str| find(kind).is_some();
    let made = if arguments.wild {
        make_wild(folder, count_of_cases, seed, &is_known, &progress)
    } else if arguments.servo {
        make_servo(folder, count_of_cases, seed, &is_known, &progress)
    } else {
        make(folder, count_of_cases, seed, &progress)
    };
    rate.done();
    made.map_err(|error| BadInput::unwritable(folder, &error))?;
    let folder = folder.display();
    terminal::print(&format!(
        "{} in {folder}/{CASES}, truth sealed in {folder}/{SEALED}\nnext: feeler blind run {folder}",
        count(total as usize, "case", "cases")
    ))
}

/// Dataset folders in order: those that `feeler blind make` made, or any dataset folders in the folder.
fn cases(folder: &Path) -> crate::Result<Vec<PathBuf>> {
    let made = folder.join(CASES);
    let inside = if made.is_dir() { made.as_path() } else { folder };
    let remedy = "name a folder that `feeler blind make` has filled, or one of dataset folders";
    let entries = fs::read_dir(inside)
        .map_err(|error| BadInput::error(format!("cannot read {}: {error}", inside.display()), remedy))?;
    let mut found: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.join("dataset.toml").is_file())
        .collect();
    found.sort();
    if found.is_empty() {
        return Err(BadInput::error(format!("no dataset folders in {}", inside.display()), remedy));
    }
    Ok(found)
}

fn run_cases(arguments: &BlindRun) -> crate::Result<()> {
    let folder = &arguments.folder;
    let answers = arguments.answers.clone().unwrap_or_else(|| folder.join(ANSWERS));
    let name =
        |case: &Path| case.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let all = cases(folder)?;
    let total = all.len();
    let left: Vec<PathBuf> =
        all.into_iter().filter(|case| !answers.join(name(case)).join(ANSWER).is_file()).collect();
    let rate = Rate::new("blind");
    let found = (total - left.len()) as u64;
    for (i, case) in left.iter().enumerate() {
        let name = name(case);
        let own = answers.join(&name);
        terminal::make_folder(&own)?;
        let write = |file: &str, text: String| terminal::write(&own.join(file), (text + "\n").as_bytes());
        // A case whose diagnosis fails counts as missed; the benchmark continues.
        let answered = match answer(arguments, case, &name) {
            Ok((answered, diagnosis)) => {
                write("diagnosis.json", terminal::json(&Advised::of(&diagnosis))?)?;
                answered
            }
            Err(error) => Answered { case: name, verdict: error.to_string(), ..Answered::default() },
        };
        write(ANSWER, terminal::json(&answered)?)?;
        rate.at(i as u64 + 1, found, total as u64);
    }
    rate.done();
    let answers = answers.display();
    terminal::print(&format!(
        "{} answered in {answers}\nnext: feeler blind score {}",
        count(total, "case", "cases"),
        folder.display()
    ))
}

/// Diagnoses one case, then computes how far the gap closes on the experiments held back.
fn answer(arguments: &BlindRun, case: &Path, name: &str) -> Result<(Answered, Diagnosis), DiagnosisError> {
    let mut dataset = Dataset::load(case)?.in_pieces();
    let held_back = arguments.folder.join(HELD_BACK).join(name);
    let held = if held_back.is_dir() {
        Some(Dataset::load(&held_back)?)
    } else if arguments.hold_back {
        let last = dataset.records.iter().rposition(|record| record.is_check);
        last.map(|last| dataset.records.remove(last))
            .map(|record| Dataset { records: vec![record], ..dataset.clone() })
    } else {
        None
    };
    let begun = Instant::now();
    let diagnosis = diagnose_within(&dataset, arguments.budget.begin(), &|_| {})?;
    let wall_s = begun.elapsed().as_secs_f64();
    let closed_held_back = (held.as_ref())
        .and_then(|held| closing(held, &diagnosis.calibrated, &diagnosis.machine, &diagnosis.noise));
    let free_run = free_runs(held.as_ref().unwrap_or(&dataset), &diagnosis.machine);
    let effects = diagnosis.effects.iter().map(|effect| AnsweredEffect {
        kind: effect.kind.to_string(),
        accepted: effect.accepted,
        probability: effect.probability,
        parameters: effect
            .parameters
            .iter()
            .map(|(name, estimate)| ((*name).to_owned(), estimate.value))
            .collect(),
        intervals: effect
            .parameters
            .iter()
            .map(|(name, estimate)| ((*name).to_owned(), estimate.ci90))
            .collect(),
    });
    let answered = Answered {
        case: name.to_owned(),
        verdict: serde_json::to_value(diagnosis.verdict)
            .ok()
            .and_then(|value| Some(value.as_str()?.to_owned()))
            .unwrap_or_default(),
        places: diagnosis.places.iter().map(|place| place.place.to_owned()).collect(),
        effects: effects.collect(),
        look_alikes: diagnosis.look_alikes.iter().map(|pair| pair.map(|kind| kind.to_string())).collect(),
        claimed: diagnosis.gap.closed,
        closed_held_back,
        free_run,
        wall_s,
    };
    Ok((answered, diagnosis))
}

fn score_cases(arguments: &BlindScore) -> crate::Result<()> {
    let folder = &arguments.folder;
    let sealed = arguments.truth.clone().unwrap_or_else(|| folder.join(SEALED));
    let given = arguments.answers.clone().unwrap_or_else(|| folder.join(ANSWERS));
    let text = fs::read_to_string(&sealed).map_err(|error| {
        BadInput::error(
            format!("cannot read {}: {error}", sealed.display()),
            "name a folder that `feeler blind make` has filled, or a file with --truth",
        )
    })?;
    let read = |text: &str| serde_json::from_str::<Vec<Case>>(text);
    let mut truth = match unseal(&text) {
        Some(opened) => read(&opened),
        None => read(&text),
    }
    .map_err(|error| {
        BadInput::error(
            format!("{} does not contain the truth of cases: {error}", sealed.display()),
            "make the cases again with `feeler blind make`",
        )
    })?;
    // A kind that was added to the library after the cases were made counts as part of the library.
    for effect in truth.iter_mut().flat_map(|case| &mut case.effects) {
        effect.outside_library &= find(&effect.kind).is_none();
    }
    let mut answers = Vec::new();
    for case in &truth {
        let file = given.join(&case.case).join(ANSWER);
        let Ok(text) = fs::read_to_string(&file) else { continue };
        let answered: Answered = serde_json::from_str(&text).map_err(|error| {
            BadInput::error(
                format!("{}: {error}", file.display()),
                "remove this file and start `feeler blind run` again",
            )
        })?;
        answers.push(answered);
    }
    if answers.is_empty() {
        return Err(BadInput::error(
            "no case has been answered",
            format!("first: feeler blind run {}", folder.display()),
        ));
    }
    let scored = score(&truth, &answers, &regressions(folder, &truth));
    let json = terminal::json(&scored)? + "\n";
    let written = terminal::write_all(
        &given,
        &[("score.json", json.clone()), ("score.html", pages::blind::page(&scored))],
    )?;
    if arguments.json {
        return terminal::print(&json);
    }
    let missed = scored.cases.iter().filter(|case| !case.right || case.sure_and_wrong);
    let misses = table(&pages::blind::CASE_COLUMNS, &[], missed.map(pages::blind::case_row));
    let measures =
        table(&["measure", "value", "cases", "to reach", ""], &[1, 2], pages::blind::measure_rows(&scored));
    terminal::print(&format!("{measures}\n\n{misses}{written}"))
}
