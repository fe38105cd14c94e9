//! From existing logs to a dataset: their contents, the role of each column, and the reason for it.
//!
//! [`import`] reads every run, keeps a summary of its columns ([`Survey`]), and writes a dataset for each
//! joint with a target and a position. Every guess is reported with its reason.

mod axis;
mod files;
mod first;
mod follow;
mod guess;
mod load;
mod pair;
mod role;
mod roles;
mod seen;
mod stated;
mod summary;
mod survey;
mod units;
mod unpaired;
mod write;

use std::path::Path;

use feeler_logs::{LogError, Run, sources};
use indexmap::IndexMap;

pub use axis::{AxisBelief, Model};
pub use follow::Follow;
pub use guess::{Chosen, Guess};
pub use role::ColumnRole;
pub use summary::{ColumnSummary, RunSummary, TableSummary};
pub use survey::{Options, Survey, Written};
pub use units::UnitGuess;

use crate::error::DiagnosisError;

/// Reads logs, and writes datasets to [`Options::out`], if given.
///
/// # Errors
/// A log or model that cannot be read, a joint that does not exist, a folder that cannot be written.
pub fn import(paths: &[&Path], options: &Options, step: &dyn Fn(&str)) -> Result<Survey, DiagnosisError> {
    let mut survey = Survey::default();
    let mut writer: Option<write::Writer> = None;
    let mut missing: Vec<&String> = options.columns.iter().map(|(_, column)| column).collect();
    for source in sources(paths)? {
        let source = source.with_clock(options.clock);
        step(&source.files[0].display().to_string());
        for mut run in source.read()? {
            if let Some(rate_hz) = options.rate_hz {
                run.set_rate(rate_hz);
            }
            missing.retain(|column| run.find(column).is_none());
            for run in run.recordings() {
                take(&mut survey, &mut writer, &run, options)?;
            }
        }
    }
    let tables = survey.runs.iter().flat_map(|run| &run.tables);
    let has_numbers = tables.flat_map(|table| &table.columns).any(|column| column.present > 1);
    if let (Some(path), false) = (paths.first(), has_numbers) {
        return Err(DiagnosisError::Unreadable {
            file: path.to_path_buf(),
            reason: "it holds no rows of numbers".into(),
            remedy: "name a log with rows: MCAP, a ROS 2 bag, Parquet, npz, npy or CSV",
        });
    }
    if let (Some(path), Some(name)) = (paths.first(), missing.first()) {
        return Err(LogError::NoColumn {
            file: path.to_path_buf(),
            name: (*name).clone(),
            remedy: "leave out --target, --position and the like: the listing then has every column".into(),
        }
        .into());
    }
    if let Some(writer) = writer {
        writer.finish(&mut survey)?;
    } else if let Some(note) = unpaired::note(&survey.joints, survey.lead.as_ref()) {
        survey.notes.push(note);
    }
    Ok(survey)
}

fn take(
    survey: &mut Survey,
    writer: &mut Option<write::Writer>,
    run: &Run,
    options: &Options,
) -> Result<(), DiagnosisError> {
    let mut guesses = roles::guess(run)?;
    if !options.columns.is_empty() {
        let joint = stated::joint(run, &options.columns, &guesses)?;
        guesses = IndexMap::from([(String::new(), joint)]);
    }
    pair::pair(run, &mut guesses, !options.columns.is_empty());
    if survey.runs.is_empty() {
        survey.lead = unpaired::lead(run, &guesses);
    }
    for plan in run.tables.iter().filter(|table| roles::is_plan(table)) {
        let note = format!(
            "`{}` holds plans of several points, and no column says which is the target when: record the \
             `reference` in the state of the controller",
            plan.name
        );
        if !survey.notes.contains(&note) {
            survey.notes.push(note);
        }
    }
    survey.runs.push(summary::of(run, &guesses));
    for (joint, guess) in guesses {
        survey.joints.entry(joint).or_insert(guess);
    }
    if options.out.is_none() {
        return Ok(());
    }
    if writer.is_none() {
        *writer = write::Writer::new(survey, options)?;
    }
    match writer {
        Some(writer) => writer.run(run, &mut survey.notes),
        None => Ok(()),
    }
}
