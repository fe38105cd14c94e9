//! `feeler diagnose`.

use std::fmt::Write as _;

use feeler_diagnosis::dataset::{Dataset, Record};
use feeler_diagnosis::report::NextExperiment;
use feeler_diagnosis::{Budget, Examination};
use feeler_files::machine_to_toml;

use crate::arguments::Diagnose;
use crate::numbers::{fine_percent, percent};
use crate::pages::diagnosis::{self, words};
use crate::terminal;
use crate::terminal::failure::BadInput;
use crate::terminal::progress::Steps;
use crate::terminal::table;

/// What was tried, on the terminal; the page has more.
const MOST_RIVALS: usize = 4;

pub(crate) fn run(arguments: &Diagnose) -> crate::Result<()> {
    let budget = arguments.budget.0.map_or_else(Budget::unlimited, Budget::of);
    let dataset = Dataset::load(&arguments.dataset)?.in_pieces();
    let folder =
        arguments.out.clone().unwrap_or_else(|| terminal::results::folder(&dataset.name, "diagnosis"));
    std::fs::create_dir_all(&folder).map_err(|error| BadInput::unwritable(&folder, &error))?;
    let steps = Steps::new(format!("diagnosing {}", dataset.name));
    let answer = Examination::within(dataset, budget, &|what| steps.at(what));
    steps.done();
    let answer = answer?;
    let json = terminal::json(&answer.diagnosis)? + "\n";
    let machine = machine_file(&answer);
    let mut files = vec![
        ("diagnosis.json", json.clone()),
        ("report.html", diagnosis::page(&answer)),
        ("machine.toml", machine.text),
    ];
    files.extend(machine.commands.iter().map(|(name, text)| (name.as_str(), text.clone())));
    if let Some(next) = &answer.diagnosis.next_experiment {
        files.push(("next-experiment.csv", excitation(next)));
    }
    let written = terminal::write_all(&folder, &files)?;
    if arguments.json {
        return terminal::print(&json);
    }
    let mut said = summary(&answer);
    if arguments.apply {
        let _ = write!(said, "\n\n{}", change(&answer));
    }
    terminal::print(&format!("{said}{written}"))
}

/// What an engineer needs to know first.
fn summary(answer: &Examination) -> String {
    let diagnosis = &answer.diagnosis;
    let gap = &diagnosis.gap;
    let mut said = format!("{}: {}\n", answer.dataset.name, words::verdict(diagnosis));
    let row = |name: &str, value: f64| vec![name.to_owned(), fine_percent(value), "%".into()];
    let mut gaps = vec![row("gap, machine as given", gap.before), row("after calibration", gap.refit)];
    if words::is_found(diagnosis) {
        gaps.push(row("with what was found", gap.after));
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
    for sentence in words::advice(diagnosis) {
        let _ = write!(said, "\n{sentence}");
    }
    for warning in &diagnosis.warnings {
        let _ = write!(said, "\nwarning: {warning}");
    }
    said.trim_end().to_owned()
}

/// What to change in the believed machine.
fn change(answer: &Examination) -> String {
    if answer.difference.is_empty() {
        return "nothing to change in the machine".into();
    }
    format!("# what to change in the believed machine\n{}", answer.difference.to_string().trim_end())
}

/// A machine file with what it reads.
struct MachineFile {
    text: String,
    /// Names and contents of the command files.
    commands: Vec<(String, String)>,
}

/// The repaired machine, driven with the commands of a check experiment, so that it runs as it is.
fn machine_file(answer: &Examination) -> MachineFile {
    let (dataset, machine) = (&answer.dataset, &answer.diagnosis.machine);
    let mut file = MachineFile { text: machine_to_toml(machine), commands: Vec::new() };
    let own = machine.contacts.values().next().map(|contact| contact.engagement);
    let is_own = |record: &&Record| {
        record.is_check && record.engagement.is_none_or(|engagement| Some(engagement) == own)
    };
    let shown = dataset.records.iter().find(is_own).or(dataset.records.iter().find(|record| record.is_check));
    let Some(record) = shown.or(dataset.records.first()) else { return file };
    let _ = write!(
        file.text,
        "\n# The commands of {}; replace these tables by a controller of your own.\n",
        record.name
    );
    for ((drive, column), command) in dataset.drives.iter().zip(&record.commands) {
        let Some((drive, _)) = machine.actuators.get_index(*drive) else { continue };
        let (name, period) = (format!("{column}.csv"), record.spacing_s);
        let _ = write!(
            file.text,
            "[controllers.recorded-{drive}]\nlaw = \"open-loop\"\ndrives = \"{drive}\"\nperiod = {period:?}\nreference = {{ kind = \"file\", file = \"{name}\" }}\n\n"
        );
        file.commands.push((name, series(record.spacing_s, command)));
    }
    let duration = record.spacing_s * record.len() as f64;
    let rate = 1.0 / record.spacing_s;
    let _ = write!(file.text, "[run]\nduration = {duration:?}\nrecord_rate = {rate:?}\n");
    file
}

fn excitation(next: &NextExperiment) -> String {
    series(next.spacing_s, &next.command)
}

/// An excitation file: `t_s,value`.
fn series(spacing_s: f64, values: &[f64]) -> String {
    let mut text = String::from("t_s,value\n");
    for (k, value) in values.iter().enumerate() {
        let _ = writeln!(text, "{},{value}", plain_time(k as f64 * spacing_s));
    }
    text
}

/// A time stamp to the nanosecond.
fn plain_time(t_s: f64) -> f64 {
    (t_s * 1e9).round() * 1e-9
}
