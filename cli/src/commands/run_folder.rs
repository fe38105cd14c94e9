//! Settings of a run, and the folder of its results.

use std::path::PathBuf;

use feeler_engine::RunSettings;

use crate::arguments::Run;
use crate::terminal;

/// The settings of a command, its other options as settings included.
pub(super) fn settings(arguments: &Run) -> Vec<String> {
    let [integrator, engine] =
        [RunSettings::INTEGRATOR, RunSettings::ENGINE].map(|field| RunSettings::key(&field));
    let integrator = arguments.integrator.iter().map(|name| format!("{integrator}={name}"));
    let engine = arguments.engine.iter().map(|name| format!("{engine}={name}"));
    arguments.settings.iter().cloned().chain(integrator).chain(engine).collect()
}

/// The folder of the results, by default one for each set of settings.
pub(super) fn folder(arguments: &Run, name: &str) -> PathBuf {
    let otherwise = || terminal::results::variant(name, &settings(arguments), "run");
    arguments.out.clone().unwrap_or_else(otherwise)
}
