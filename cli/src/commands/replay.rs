//! `feeler replay`.

use std::fmt::Write as _;

use feeler_diagnosis::dataset::{Dataset, in_words};
use feeler_diagnosis::replay::{Replay, replay};
use feeler_files::Document;
use serde::Serialize;

use crate::arguments::Replay as Arguments;
use crate::numbers::{percent, with_unit};
use crate::terminal;
use crate::terminal::progress::Steps;
use crate::terminal::table;
use crate::units::Units;

/// All predictions of a dataset, as programs read them. The book shows the comments.
#[derive(Serialize)]
struct Replayed<'a> {
    /// Name of the dataset.
    dataset: &'a str,
    /// Name of the machine.
    machine: &'a str,
    /// Findings of the check of the records.
    warnings: &'a [String],
    /// Each experiment, with the errors of its columns.
    experiments: &'a [Replay],
}

pub(crate) fn run(arguments: &Arguments) -> crate::Result<()> {
    let machine = Document::load(&arguments.machine)?.scenario.machine;
    let dataset = Dataset::load_for(&arguments.dataset, &machine)?;
    terminal::make_folder(&arguments.out)?;
    let steps = Steps::new(format!("replaying {}", dataset.name));
    steps.at("predicting");
    let replays = replay(&machine, &dataset);
    steps.done();
    let replays = replays?;
    let warnings = in_words(&dataset.warnings);
    let all = Replayed {
        dataset: &dataset.name,
        machine: &machine.name,
        warnings: &warnings,
        experiments: &replays,
    };
    let json = terminal::json(&all)? + "\n";
    let mut files: Vec<(String, String)> = vec![("replay.json".into(), json.clone())];
    files.extend(replays.iter().map(|replay| (replay.csv_name(), replay.csv(&dataset))));
    let written = terminal::write_all(&arguments.out, &files)?;
    if arguments.json {
        return terminal::print(&json);
    }
    let units = Units::of(&machine);
    let mut rows = Vec::new();
    for replay in &replays {
        for (c, error) in replay.errors.iter().enumerate() {
            let unit = units.unit(dataset.channels[c].quantity(&machine));
            let experiment = if c == 0 { replay.experiment.clone() } else { String::new() };
            // A constant column has no variation to which its error could relate.
            let share =
                |share: f64| if error.scale > 0.0 { format!("{} %", percent(share)) } else { "-".into() };
            let row = [
                error.column.clone(),
                share(error.relative_in_windows),
                share(error.relative),
                with_unit(error.rms, unit),
            ];
            rows.push(std::iter::once(experiment).chain(row).collect());
        }
    }
    let header = ["experiment", "column", "error in 50 ms windows", "error, free", "free, rms"];
    let mut said = table(&header, &[2, 3, 4], rows);
    for warning in &warnings {
        let _ = write!(said, "\nwarning: {warning}");
    }
    terminal::print(&format!("{said}{written}"))
}
