//! `feeler replay`.

use std::fmt::Write as _;

use feeler_diagnosis::dataset::{Dataset, in_words};
use feeler_diagnosis::replay::replay;
use feeler_files::Document;
use serde_json::json;

use crate::arguments::Replay as Arguments;
use crate::numbers::{percent, with_unit};
use crate::terminal;
use crate::terminal::progress::Steps;
use crate::terminal::table;
use crate::units::Units;

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
    // The book shows the remarks as the meaning of the keys.
    let json = json!({
        // Name of the dataset.
        "dataset": dataset.name,
        // Name of the machine.
        "machine": machine.name,
        // Findings of the check of the records.
        "warnings": warnings,
        // Errors of each column of each experiment, over short windows and over the whole record.
        "experiments": replays,
    });
    let json = terminal::json(&json)? + "\n";
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
