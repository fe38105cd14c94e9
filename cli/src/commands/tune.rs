//! `feeler tune`.

use std::fmt::Write as _;
use std::path::Path;

use feeler_diagnosis::difference::Difference;
use feeler_files::{Document, Draft};
use feeler_studies::doubts;
use feeler_studies::tune::{Spec, Uncertain, further, machines, tune};
use serde_json::Value;

use super::why::{kept, next, write_set};
use crate::arguments::Tune;
use crate::pages::tune::summary;
use crate::terminal;
use crate::terminal::failure::BadInput;
use crate::terminal::progress::Steps;
use crate::units::Units;

pub(crate) fn run(arguments: &Tune) -> crate::Result<()> {
    let spec = Spec::parse(&arguments.spec)?;
    let document = Draft::load_with(&arguments.file, &arguments.settings)?.build()?;
    terminal::warn(&doubts(&document.scenario).all);
    let found = arguments.diagnosis.as_deref().map(|path| Found::read(path, &document)).transpose()?;
    // The tuned machine has the calibrated values and the effects found. The written file keeps its own
    // machine.
    let settings = found.iter().flat_map(|found| &found.settings);
    let all: Vec<String> = settings.chain(&arguments.settings).cloned().collect();
    let diagnosed = Draft::load_with(&arguments.file, &all)?.build()?;
    let uncertain = found.map_or_else(Vec::new, |found| found.uncertain);
    let drawn = machines(&diagnosed, &uncertain, arguments.draws.into(), 0)?;
    let steps = Steps::new(format!("tuning {}", document.scenario.machine.name));
    let tuned = tune(&diagnosed, &spec, &drawn, &|what| steps.at(what));
    steps.done();
    let tuned = tuned?;
    let mut written = String::new();
    if let Some(folder) = &arguments.code {
        let code = &tuned.equation.code;
        let files = [("controller.c", code.c.clone()), ("controller.rs", code.rust.clone())];
        written = terminal::write_all(folder, &files)?;
    }
    if let Some(out) = &arguments.out {
        let all: Vec<String> = arguments.settings.iter().chain(&tuned.settings).cloned().collect();
        let set = write_set(&arguments.file, &document, &all, out)?;
        let head = if written.is_empty() { "\n\nwrote" } else { "" };
        let (next, kept) = (next(&set.compared, out), kept(set.backup.as_deref()));
        let _ = write!(written, "{head}\n  {}{kept}\n\n{next}", out.display());
    }
    if arguments.json {
        return terminal::print(&terminal::json(&tuned)?);
    }
    let machine = &document.scenario.machine;
    let further = further(&document.scenario, &spec, &tuned.controller);
    let said = summary(&machine.name, &tuned, &uncertain, Units::of(machine), further.as_deref());
    terminal::print(&format!("{said}{written}"))
}

/// Results of a diagnosis.
struct Found {
    /// Calibrated values in the form of `--set`.
    settings: Vec<String>,
    /// Parameters of accepted effects.
    uncertain: Vec<Uncertain>,
}

impl Found {
    /// Reads the results of `feeler diagnose`, and the repaired machine if its file is beside them.
    fn read(path: &Path, document: &Document) -> crate::Result<Self> {
        let file = if path.is_dir() { path.join("diagnosis.json") } else { path.to_owned() };
        let wrong = |what: &str| {
            BadInput::error(
                format!("{}: {what}", file.display()),
                "name a folder that `feeler diagnose` wrote, or its diagnosis.json",
            )
        };
        let text = std::fs::read_to_string(&file).map_err(|error| wrong(&error.to_string()))?;
        let json: Value = serde_json::from_str(&text).map_err(|error| wrong(&error.to_string()))?;
        let effects = json["effects"].as_array().ok_or_else(|| wrong("it has no `effects`"))?;
        let mut uncertain = Vec::new();
        for effect in effects.iter().filter(|effect| effect["accepted"] == true) {
            let (on, kind) = effect["on"]
                .as_str()
                .zip(effect["kind"].as_str())
                .ok_or_else(|| wrong("an effect has no `on` or no `kind`"))?;
            for (name, estimate) in effect["parameters"].as_object().into_iter().flatten() {
                let number = |value: &Value| {
                    value.as_f64().ok_or_else(|| wrong("an end of an interval is not a number"))
                };
                let value = number(&estimate["value"])?;
                let ends = [number(&estimate["ci90"][0])?, number(&estimate["ci90"][1])?];
                // An interval across zero is cut at zero, so that a parameter keeps its sign.
                let interval = ends.map(|end| if end * value < 0.0 { 0.0 } else { end });
                uncertain.push(Uncertain { key: format!("{on}.effects.{kind}.{name}"), value, interval });
            }
        }
        let machine = file.with_file_name("machine.toml");
        let mut settings = Vec::new();
        if machine.is_file() {
            let repaired = Document::load(&machine)?.scenario.machine;
            let difference = Difference::between(&document.scenario.machine, &repaired);
            if let Some(gone) = difference.removed.first() {
                return Err(BadInput::error(
                    format!(
                        "{}: the diagnosis replaces `{gone}`, which the scenario still has",
                        file.display()
                    ),
                    "remove that table from the scenario, then tune",
                ));
            }
            settings
                .extend(difference.changed.iter().map(|changed| format!("{}={}", changed.key, changed.new)));
        }
        Ok(Self { settings, uncertain })
    }
}
