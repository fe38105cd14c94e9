//! Settings of a run, and the folder of its results.

use std::path::PathBuf;

use crate::arguments::Run;
use crate::terminal;

/// The settings of a command, its other options as settings included.
pub(super) fn settings(arguments: &Run) -> Vec<String> {
    let integrator = arguments.integrator.iter().map(|integrator| format!("run.integrator={integrator}"));
    let engine = arguments.engine.iter().map(|engine| format!("run.engine={engine}"));
    arguments.settings.iter().cloned().chain(integrator).chain(engine).collect()
}

/// The folder of the results, by default one for each set of settings.
pub(super) fn folder(arguments: &Run, name: &str) -> PathBuf {
    let otherwise = || terminal::results::variant(name, &settings(arguments), "run");
    arguments.out.clone().unwrap_or_else(otherwise)
}
