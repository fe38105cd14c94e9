//! The whole table.

use std::path::PathBuf;

use crate::error::ValidationError;
use crate::experiments::{ResponseEffort, onset_row, paper_axes, response_rows, two_route_rows};
use crate::table::{CheckRow, CheckTable};
use crate::{claims, closed_forms, convergence, engines, files, landmarks, models, random_machines};

/// Delays of the simulated onsets of instability, in samples.
pub const ONSET_DELAYS: [f64; 4] = [0.0, 0.37, 1.0, 2.5];

/// Extent of a validation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ValidateOptions {
    /// Text of the independent critical gains (`critical-gains.json`), if available.
    pub critical_gains_json: Option<String>,
    /// Folder of the scenario files, if available: the state space of the paper's machines then also comes
    /// from their files.
    pub scenarios: Option<PathBuf>,
    /// Only checks that take seconds: two of the paper's machines instead of ten, fewer random ones.
    pub quick: bool,
}

/// Makes every check and returns the table; `progress` receives the name of each group before it begins.
///
/// # Errors
/// [`ValidationError`] if a check cannot be made.
pub fn validate(
    options: &ValidateOptions,
    mut progress: impl FnMut(&str),
) -> Result<CheckTable, ValidationError> {
    let mut table = CheckTable::default();
    let mut group = |name: &str,
                     rows: &dyn Fn() -> Result<Vec<CheckRow>, ValidationError>|
     -> Result<(), ValidationError> {
        progress(name);
        table.rows.extend(rows()?);
        Ok(())
    };
    group("closed forms", &closed_forms::closed_form_rows)?;
    group("table of models", &models::model_rows)?;
    if let Some(json) = &options.critical_gains_json {
        group("critical gains", &|| models::critical_gain_rows(json))?;
    }
    group("three routes", &two_route_rows)?;
    if let Some(folder) = &options.scenarios {
        group("three routes, from the scenario files", &|| files::file_rows(folder))?;
        group("convergence", &|| convergence::convergence_rows(folder))?;
    }
    group("claims of the paper", &claims::claim_rows)?;
    group("two engines", &|| {
        let steps_s = engines::default_steps_s();
        Ok(engines::engine_rows(&engines::agreements(options.scenarios.as_deref(), &steps_s)?))
    })?;
    group("random machines", &|| random_machines::random_machine_rows(if options.quick { 60 } else { 600 }))?;
    if !options.quick {
        group("landmarks by simulated experiments", &landmarks::simulated_rows)?;
    }
    let axes = paper_axes();
    let chosen = if options.quick { &axes[..2] } else { &axes[..] };
    for (name, axis) in chosen {
        let effort = if options.quick { ResponseEffort::QUICK } else { ResponseEffort::FULL };
        group(&format!("frequency response: {name}"), &|| response_rows(name, axis, effort))?;
        group(&format!("onset of instability: {name}"), &|| {
            ONSET_DELAYS
                .iter()
                .map(|&delay| onset_row(name, axis, delay, if options.quick { 12.0 } else { 40.0 }))
                .collect()
        })?;
    }
    Ok(table)
}
