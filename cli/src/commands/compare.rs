//! `feeler compare`.

use std::path::{Component, Path, PathBuf};

use feeler_diagnosis::dataset::Dataset;
use feeler_engine::Scenario;
use feeler_files::{Document, Draft, EXAMPLE_KEY};
use feeler_studies::glimpse::{Glimpse, Loci, theory};
use feeler_studies::run::{self as runs, about_parquet};
use rayon::prelude::*;
use serde::Serialize;

use super::run::RESOLVED;
use crate::arguments::Compare as Arguments;
use crate::pages::compare::{self, ComparedDatasets, ComparedScenarios, Taken};
use crate::terminal;
use crate::terminal::failure::BadInput;
use crate::terminal::progress::Busy;

pub(crate) fn run(arguments: &Arguments) -> crate::Result<()> {
    let are_datasets = arguments.what.iter().map(|path| is_dataset(path)).collect::<Vec<_>>();
    if are_datasets.contains(&true) {
        if are_datasets.contains(&false) || !arguments.settings.is_empty() {
            return Err(BadInput::error(
                "datasets and scenarios cannot be compared with each other",
                "name only datasets, or only scenarios and folders of runs; to draw records over \
                 predictions: feeler live FILE --data DATASET",
            ));
        }
        let sets: Vec<Dataset> =
            arguments.what.iter().map(|path| Dataset::load(path)).collect::<Result<_, _>>()?;
        let compared = ComparedDatasets::new(&sets);
        let said = match compared.rows() {
            rows if rows.is_empty() => compare::NOTHING_COMMON.to_owned(),
            rows => terminal::table(&compare::RECORD_HEADS, &[3, 4, 5], rows),
        };
        return finish(arguments, &compared, compare::datasets(&sets), &said);
    }
    let documents = documents(arguments)?;
    if documents.len() < 2 {
        return Err(BadInput::error(
            "one scenario alone cannot be compared",
            format!("name another, or a variant of it, as in --set {EXAMPLE_KEY}=0.4"),
        ));
    }
    let busy = Busy::new("running and analysing each");
    let taken: Vec<Taken> = (documents.into_par_iter())
        .map(|(name, document)| Taken { glimpse: as_run(&document.scenario), name, document })
        .collect();
    drop(busy);
    let table = terminal::table(&compare::heads(&taken), &[], compare::figures(&taken));
    let keys = compare::differing(&taken);
    let keys = if keys.is_empty() {
        "no key differs".to_owned()
    } else {
        terminal::table(&compare::heads(&taken), &[], keys)
    };
    let compared = ComparedScenarios::new(&taken);
    finish(arguments, &compared, compare::page(&taken), &format!("{keys}\n\n{table}"))
}

/// The run, with rows as in `feeler run` so that both print the same times, and linear theory.
fn as_run(scenario: &Scenario) -> Glimpse {
    let (run, theory) = rayon::join(|| runs::run(scenario, &mut |_| {}), || theory(scenario, Loci::Drawn));
    Glimpse { run, theory }
}

/// Writes the page and its numbers, and prints the numbers as text or as JSON.
fn finish(arguments: &Arguments, compared: &impl Serialize, page: String, said: &str) -> crate::Result<()> {
    let json = terminal::json(compared)? + "\n";
    let files = [("report.html", page), ("compare.json", json.clone())];
    let written = terminal::write_all(&arguments.out, &files)?;
    if arguments.json {
        return terminal::print(&json);
    }
    terminal::print(&format!("{said}{written}"))
}

fn is_dataset(path: &Path) -> bool {
    path.join("dataset.toml").exists() || path.file_name().is_some_and(|name| name == "dataset.toml")
}

fn documents(arguments: &Arguments) -> crate::Result<Vec<(String, Document)>> {
    let mut documents = Vec::new();
    for (path, name) in arguments.what.iter().zip(names(&arguments.what)) {
        documents.push((name, document(path)?));
    }
    if let [(_, only)] = documents.as_slice()
        && !arguments.settings.is_empty()
    {
        let mut variants = Vec::new();
        for setting in &arguments.settings {
            let mut draft: Draft = only.draft().clone();
            draft.set(setting)?;
            variants.push((setting.clone(), draft.build()?));
        }
        documents.extend(variants);
    } else if !arguments.settings.is_empty() {
        return Err(BadInput::error(
            "--set makes variants of one file, and several are named",
            "name one file, or leave --set out",
        ));
    }
    Ok(documents)
}

/// The paths without their common folders.
fn names(paths: &[PathBuf]) -> Vec<String> {
    let parts: Vec<Vec<Component<'_>>> = paths.iter().map(|path| path.components().collect()).collect();
    let folders = parts.iter().map(|own| own.len().saturating_sub(1)).min().unwrap_or(0);
    let shared = (0..folders).take_while(|&i| parts.iter().all(|own| own[i] == parts[0][i])).count();
    parts.iter().map(|own| own[shared..].iter().collect::<PathBuf>().display().to_string()).collect()
}

/// A scenario from its file, or from the folder of its run.
fn document(path: &Path) -> crate::Result<Document> {
    if !path.is_dir() {
        return Ok(Document::load(path)?);
    }
    let trace = path.join("trace.parquet");
    if !trace.exists() {
        return Err(BadInput::error(
            format!("{} holds no run: there is no trace.parquet", path.display()),
            "name a folder that `feeler run` wrote, a scenario file, or a dataset",
        ));
    }
    let about = about_parquet(&trace)?;
    let text = about.into_iter().find(|(key, _)| key == RESOLVED).map(|(_, text)| text).ok_or_else(|| {
        BadInput::error(
            format!("{} does not say which scenario it is of", trace.display()),
            "run the scenario again, with this version of feeler",
        )
    })?;
    Ok(Document::parse(&text, &trace.display().to_string())?)
}
