//! `feeler check`.

mod as_json;
mod found;

use std::path::Path;

use feeler_diagnosis::DiagnosisError;
use feeler_diagnosis::dataset::{Dataset, Fault, FaultKind, in_words};
use feeler_engine::{EngineError, Program};
use feeler_files::{ArmFile, CellFile, DatasetFile, Draft, SweepFile, read_text};
use feeler_studies::doubts;

use crate::arguments::Check;
use crate::numbers::count;
use crate::terminal;
use crate::terminal::failure::Failure;
use found::{Mistakes, Sound, is_wrong_unit};

/// The file in a dataset's folder that describes it.
const DATASET: &str = "dataset.toml";

pub(crate) fn run(arguments: &Check) -> crate::Result<()> {
    let (mut sound, mut consistent) = (true, true);
    let mut results = Vec::new();
    for path in &arguments.files {
        let result = check(path);
        sound &= result.is_ok();
        consistent &= !result.as_ref().is_ok_and(Sound::has_wrong_unit);
        if arguments.json {
            results.push(as_json::Checked::new(path, &result));
            continue;
        }
        match result {
            Ok(sound) => {
                let head = if sound.has_wrong_unit() { "wrong unit" } else { "ok" };
                terminal::print(&format!("{head}  {}: {}", path.display(), sound.about))?;
                let (notes, warnings): (Vec<Fault>, Vec<Fault>) =
                    sound.warnings.into_iter().partition(|fault| gravity(fault) == INFORMS);
                let doubts = sound
                    .doubts
                    .iter()
                    .map(|doubt| format!("warning: {}: {}; {}", doubt.key, doubt.message, doubt.remedy));
                let warnings = in_words(&warnings).into_iter().map(|words| format!("warning: {words}"));
                let notes = in_words(&notes).into_iter().map(|words| format!("note: {words}"));
                let mut lines = warnings.chain(doubts).chain(notes);
                lines.try_for_each(|line| terminal::print(&format!("    {line}")))?;
            }
            Err(mistakes) => terminal::complain(&mistakes.error().report(terminal::has_colours())),
        }
    }
    if arguments.json {
        terminal::print(&terminal::json(&results)?)?;
    }
    match (sound, consistent) {
        (true, true) => Ok(()),
        (true, false) => Err(Failure::CheckFailed),
        (false, _) => Err(Failure::Reported),
    }
}

/// Rank of a mere note.
const INFORMS: u8 = 4;

/// Rank of a warning: contradictions first, then columns that are ignored, repaired records, and notes.
fn gravity(fault: &Fault) -> u8 {
    match fault.kind {
        _ if is_wrong_unit(fault) => 0,
        _ if fault.kind.is_contradiction() => 1,
        FaultKind::Constant { .. } | FaultKind::Clipped { .. } => 2,
        FaultKind::WeakExcitation { .. }
        | FaultKind::NoiseNotStated { .. }
        | FaultKind::SetAside
        | FaultKind::Cut { .. } => INFORMS,
        _ => 3,
    }
}

fn check(path: &Path) -> Result<Sound, Mistakes> {
    let folder = path.join(DATASET);
    if folder.is_file() || path.file_name().is_some_and(|name| name == DATASET) {
        let file = if folder.is_file() { &folder } else { path };
        let dataset = DatasetFile::load(file).map_err(Mistakes::Format)?;
        let warnings = check_series(file)?;
        let experiments = count(dataset.experiments.len(), "experiment", "experiments");
        let about =
            format!("dataset of {experiments}, {}", count(dataset.columns.len(), "column", "columns"));
        return Ok(Sound { about, warnings, doubts: Vec::new() });
    }
    let text = read_text(path).map_err(Mistakes::Format)?;
    if has_line(&text, "urdf") {
        let arm = ArmFile::load(path).map_err(Mistakes::Format)?;
        let about = format!("arm `{}` with {}", arm.name, count(arm.arm.drives().len(), "joint", "joints"));
        return Ok(Sound { about, warnings: Vec::new(), doubts: arm.doubts });
    }
    if has_line(&text, "[axes") {
        let sweep = SweepFile::load(path).map_err(Mistakes::Format)?;
        return Ok(format!("sweep over {}", count(sweep.axes.len(), "axis", "axes")).into());
    }
    let draft = Draft::load(path).map_err(Mistakes::Format)?;
    if draft.has_arm() {
        let file = CellFile::build(draft).map_err(Mistakes::Format)?;
        let workpiece = file.cell.workpiece.shape.name();
        let joints = count(file.cell.joints.len(), "joint", "joints");
        let about = format!("scenario `{}` of an arm with {joints} on a {workpiece}", file.name);
        return Ok(Sound { about, warnings: Vec::new(), doubts: file.doubts });
    }
    let document = draft.build().map_err(Mistakes::Format)?;
    Program::new(&document.scenario).map_err(|error| match error {
        EngineError::Problems { problems } => Mistakes::Format(document.locate_problems(&problems)),
        other => Mistakes::Engine(other),
    })?;
    let machine = &document.scenario.machine;
    let parts = [
        count(machine.bodies.len(), "body", "bodies"),
        count(machine.contacts.len(), "contact", "contacts"),
        count(document.scenario.controllers.len(), "controller", "controllers"),
    ];
    let about = format!("scenario `{}` with {}", machine.name, parts.join(", "));
    Ok(Sound { about, warnings: Vec::new(), doubts: doubts(&document.scenario).all })
}

/// Checks the series of a dataset. Faults that the diagnosis repairs by an assumption are warnings; other
/// faults are mistakes.
fn check_series(file: &Path) -> Result<Vec<Fault>, Mistakes> {
    let dataset = Dataset::load(file).map_err(|error| match error {
        DiagnosisError::Format(error) => Mistakes::Format(error),
        other => Mistakes::Series(other),
    })?;
    let mut warnings = dataset.warnings;
    warnings.sort_by_key(gravity);
    Ok(warnings)
}

/// Whether a line of the text begins with `beginning`. A sweep has a table of axes, an arm has a URDF.
fn has_line(text: &str, beginning: &str) -> bool {
    text.lines().any(|line| line.trim_start().starts_with(beginning))
}
