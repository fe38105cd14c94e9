//! `feeler import`.

mod as_json;

use std::fmt::Write as _;
use std::path::Path;

use feeler_diagnosis::import::{
    ColumnRole, Guess, Model, Options, RunSummary, Survey, TableSummary, UnitGuess, import,
};
use feeler_logs::ClockUnit;
use feeler_problem::short;

use crate::arguments::Import;
use crate::terminal;
use crate::terminal::failure::Failure;
use crate::terminal::progress::Steps;
use crate::terminal::table;

/// Number of runs whose columns are listed; the others have one line.
const LISTED: usize = 1;

pub(crate) fn run(arguments: &Import) -> crate::Result<()> {
    let paths: Vec<&Path> = arguments.logs.iter().map(AsRef::as_ref).collect();
    let steps = Steps::new("reading");
    let survey = import(&paths, &options(arguments), &|what| steps.at(what));
    steps.done();
    let survey = survey?;
    if arguments.json {
        terminal::print(&terminal::json(&as_json::Imported::new(&survey))?)?;
    } else {
        terminal::print(listing(&survey, arguments.out.is_some()).trim_end())?;
    }
    // The notes of the listing say why.
    if arguments.out.is_some() && survey.datasets.is_empty() { Err(Failure::Reported) } else { Ok(()) }
}

fn options(arguments: &Import) -> Options {
    let model = (arguments.machine.clone().map(Model::Machine))
        .or_else(|| arguments.urdf.clone().map(Model::Urdf))
        .or_else(|| arguments.mjcf.clone().map(Model::Mjcf));
    let stated = [
        (ColumnRole::Target, &arguments.target),
        (ColumnRole::TargetVelocity, &arguments.target_velocity),
        (ColumnRole::FeedForward, &arguments.feed_forward),
        (ColumnRole::Command, &arguments.command),
        (ColumnRole::Position, &arguments.position),
        (ColumnRole::Effort, &arguments.effort),
    ];
    Options {
        clock: arguments.clock.as_deref().and_then(ClockUnit::named),
        rate_hz: arguments.rate,
        joint: arguments.joint.clone(),
        columns: stated.into_iter().filter_map(|(role, name)| Some((role, name.clone()?))).collect(),
        out: arguments.out.clone(),
        model,
    }
}

fn listing(survey: &Survey, is_written: bool) -> String {
    let mut text = String::new();
    for run in survey.runs.iter().take(LISTED) {
        described(&mut text, run);
    }
    if survey.runs.len() > LISTED {
        let rows = survey.runs[LISTED..].iter().map(|run| {
            let rows = run.tables.iter().map(|table| table.rows).max().unwrap_or(0);
            let duration_s = run.tables.iter().map(|table| table.duration_s).fold(0.0, f64::max);
            let lost: usize = run.tables.iter().map(|table| table.lost.0).sum();
            vec![run.name.clone(), rows.to_string(), short(duration_s), lost.to_string()]
        });
        let _ = writeln!(text, "{}\n", table(&["other runs", "rows", "s", "lost rows"], &[1, 2, 3], rows));
    }
    let followed = survey.joints.iter().filter(|(_, guess)| guess.follow.is_some());
    for (joint, guess) in followed {
        followed_by(&mut text, joint, guess);
    }
    for note in &survey.notes {
        let _ = writeln!(text, "note: {note}");
    }
    for written in &survey.datasets {
        // A file of one axis names no joint.
        let joint = if written.joint.is_empty() { "joint" } else { written.joint.as_str() };
        let _ = writeln!(
            text,
            "\nwrote {} with {} of joint `{}`; look at it with: feeler check {}",
            written.folder.display(),
            crate::numbers::count(written.experiments.len(), "experiment", "experiments"),
            joint,
            written.folder.display()
        );
        for assumption in &written.assumptions {
            let _ = writeln!(text, "  assumed: {assumption}");
        }
    }
    if !is_written && survey.joints.values().any(|guess| guess.follow.is_some()) {
        let _ = writeln!(
            text,
            "\nwrite a dataset of each joint with: --out DIR [--machine FILE | --urdf FILE | --mjcf FILE]"
        );
    }
    text
}

fn described(text: &mut String, run: &RunSummary) {
    for found in &run.tables {
        let _ = writeln!(text, "{}", headline(run, found));
        let rows = found.columns.iter().filter(|column| column.present > 0).map(|column| {
            let role = column.role.as_ref().map_or_else(String::new, |(role, joint, why)| {
                let of = if joint.is_empty() { String::new() } else { format!(" of {joint}") };
                format!("{}{of} ({why})", role.noun())
            });
            vec![
                column.name.clone(),
                column.present.to_string(),
                short(column.range[0]),
                short(column.range[1]),
                role,
            ]
        });
        let _ = writeln!(
            text,
            "{}\n",
            table(&["column", "values", "least", "most", "taken for"], &[1, 2, 3], rows)
        );
        let empty: Vec<&str> = found
            .columns
            .iter()
            .filter(|column| column.present == 0)
            .map(|column| column.name.as_str())
            .collect();
        if !empty.is_empty() {
            let _ = writeln!(text, "without numbers: {}\n", empty.join(", "));
        }
    }
    for note in &run.notes {
        let _ = writeln!(text, "note: {note}");
    }
}

/// Lowest rate at which a servo is logged, Hz.
const SLOW_HZ: f64 = 1.0;

fn headline(run: &RunSummary, found: &TableSummary) -> String {
    let rate = found.rate_hz.map_or_else(String::new, |rate| format!(" at {} Hz", short(rate)));
    let clock = found.clock.as_ref().map_or_else(
        || "no column is a clock: state the rate of the rows with --rate HZ".to_owned(),
        |(column, unit, why)| format!("clock `{column}` in {unit}: {why}"),
    );
    let lost = match found.lost {
        (0, _) => String::new(),
        (rows, longest_s) => {
            let rows = crate::numbers::count(rows, "row is", "rows are");
            format!("; {rows} lost, up to {} s together", short(longest_s))
        }
    };
    let back = found.back_in_row.map_or_else(String::new, |row| format!("; it goes back in row {row}"));
    let is_slow = found.rate_hz.is_some_and(|rate_hz| rate_hz < SLOW_HZ);
    let is_in_s = found.clock.as_ref().is_some_and(|(_, unit, _)| *unit == ClockUnit::Seconds.symbol());
    let slow = if is_slow && is_in_s { " (if it counts milliseconds: --clock ms)" } else { "" };
    let name = if found.name.is_empty() { &run.name } else { &found.name };
    format!("{name}: {} rows{rate} over {} s; {clock}{slow}{back}{lost}", found.rows, short(found.duration_s))
}

fn followed_by(text: &mut String, joint: &str, guess: &Guess) {
    let name = |role| guess.columns.get(&role).map_or("", |chosen| chosen.column.as_str());
    let Some(follow) = guess.follow else { return };
    let of = if joint.is_empty() { String::new() } else { format!("{joint}: ") };
    let _ = writeln!(
        text,
        "{of}`{}` {} `{}` {} ms later (correlation {:.4})",
        name(ColumnRole::Position),
        if follow.is_turned() { "moves against" } else { "follows" },
        name(ColumnRole::Target),
        short(1e3 * follow.lag_s),
        follow.correlation
    );
    if follow.is_turned() {
        let _ = writeln!(text, "  reverse the sign of one of the two: `scale` in dataset.toml, times -1");
    }
    for (role, chosen) in &guess.columns {
        if let Some((unit, why)) = &chosen.unit {
            let _ = writeln!(text, "  {} is taken for {}: {why}", role.noun(), unit_words(unit));
        }
    }
}

fn unit_words(unit: &UnitGuess) -> String {
    match unit {
        UnitGuess::Symbol(symbol) => symbol.to_string(),
        UnitGuess::Counts(each) => format!("counts of {} rad", short(*each)),
    }
}
