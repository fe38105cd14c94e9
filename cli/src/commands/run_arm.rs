//! `feeler run` of a whole arm.

use std::path::{Path, PathBuf};

use feeler_files::{CellFile, Draft};
use feeler_studies::run::{CellRun, run_cell, write_csv, write_parquet};

use crate::arguments::Run;
use crate::numbers::{percent, plain, split, with_unit};
use crate::terminal::failure::BadInput;
use crate::terminal::progress::Progress;
use crate::terminal::table;
use crate::units::Units;
use crate::{pages, terminal, words};

pub(crate) fn run(arguments: &Run, draft: Draft) -> crate::Result<()> {
    if arguments.as_sweep {
        return Err(BadInput::error(
            "a whole arm cannot run as a variant of a sweep",
            "run it without --as-sweep, or sweep the axis from `feeler reduce`",
        ));
    }
    let file = CellFile::build(draft)?;
    terminal::warn(&file.doubts);
    let folder = super::run_folder::folder(arguments, &file.name);
    terminal::make_folder(&folder)?;
    let mut progress = Progress::new(file.name.clone());
    let result = run_cell(&file, &mut |at| progress.at(at.t_s / at.duration_s));
    progress.done();
    let result = result?;
    let written = write(arguments, &file, &result, &folder)?;
    if arguments.json {
        return terminal::print(&terminal::json(&result.summary)?);
    }
    let files = written.iter().map(|path| format!("  {}", path.display())).collect::<Vec<_>>().join("\n");
    let units = Units::of(&file.cell.scenario.machine);
    let said = format!(
        "{}{}",
        words::outcome(&result.summary.figures, units),
        pages::arm_run::limits(&result.summary)
    );
    let said = terminal::wrapped(&format!("{}: {said}", file.name));
    terminal::print(&format!("{said}\n\n{}\n\nwrote\n{files}", figures(&result, units)))
}

fn write(arguments: &Run, file: &CellFile, result: &CellRun, folder: &Path) -> crate::Result<Vec<PathBuf>> {
    let [trace, csv, summary, report] =
        ["trace.parquet", "trace.csv", "summary.json", "report.html"].map(|name| folder.join(name));
    let about = [
        ("feeler.version", env!("CARGO_PKG_VERSION").to_owned()),
        ("feeler.scenario", file.text().to_owned()),
        ("feeler.seed", file.cell.scenario.run.seed.to_string()),
        ("feeler.integrator", "rk4 of a whole arm".to_owned()),
    ];
    write_parquet(&result.motion, &about, &trace)?;
    if arguments.csv {
        write_csv(&result.motion, &csv)?;
    }
    terminal::write(&summary, (terminal::json(&result.summary)? + "\n").as_bytes())?;
    terminal::write(&report, pages::arm_run::page(file, &arguments.settings, result)?.as_bytes())?;
    let csv = arguments.csv.then_some(csv);
    Ok([Some(trace), csv, Some(summary), Some(report)].into_iter().flatten().collect())
}

/// The summary as a table: measure, number, unit, remark.
fn figures(result: &CellRun, units: Units) -> String {
    let summary = &result.summary;
    let figures = &summary.figures;
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut row = |name: &str, (number, unit): (String, String), remark: String| {
        rows.push(vec![name.to_owned(), number, unit, remark]);
    };
    let none = || ("-".to_owned(), String::new());
    row("outcome", (String::new(), String::new()), words::label(figures).to_owned());
    row(
        "peak force",
        split(figures.peak_force_n, "N"),
        format!("at {}", with_unit(result.contact.peak_at_s, "s")),
    );
    row("final force", split(summary.final_force_n, "N"), "mean of the last tenth of the run".into());
    if let Some(response) = figures.response {
        let reference = response
            .final_reference_n
            .map_or_else(String::new, |reference| format!("of {}", with_unit(reference, "N")));
        row(
            "overshoot",
            response.overshoot.map_or_else(none, |share| (percent(share), "%".into())),
            reference,
        );
        let within = || format!("to within {} until the end", with_unit(response.band_n, "N"));
        let band = words::rests_outside(figures, units).unwrap_or_else(within);
        row("settling time", response.settling_time_s.map_or_else(none, |time| split(time, "s")), band);
    }
    row("bounces", (figures.bounces.to_string(), String::new()), String::new());
    row(
        "contact time",
        split(figures.contact_time_s, "s"),
        format!("{} % of the run", percent(figures.contact_share)),
    );
    if let Some(oscillation) = &figures.oscillation {
        row(
            "chatter frequency",
            split(oscillation.frequency_hz, "Hz"),
            format!("{} impacts per second", plain(oscillation.impacts_per_s)),
        );
        row("chatter amplitude", split(oscillation.amplitude_n, "N"), "half of peak to peak".into());
    }
    row(
        "saturation",
        (percent(figures.saturation_share), "%".into()),
        "of the time, some joint or the controller".into(),
    );
    row("sideways", split(summary.sideways_m, "m"), "largest sideways error of the tool".into());
    row(
        "joint events",
        (summary.joint_events.to_string(), String::new()),
        "sticking, sliding and flank contact of joints".into(),
    );
    row(
        "simulated",
        split(figures.simulated_s, "s"),
        format!("{} steps of at most {}", figures.steps, with_unit(summary.step_s, "s")),
    );
    row(
        "time taken",
        split(figures.wall_s, "s"),
        format!("{} per simulated second", with_unit(summary.wall_s_per_simulated_s, "s")),
    );
    table(&[], &[1], rows)
}
