//! Chatter as predicted by describing functions, for comparison with the simulation.

use feeler_analysis::{LimitCycle, limit_cycles};
use rayon::prelude::*;

use super::axes::DrawnAxis;
use feeler_files::{Document, Setting};

/// Predicted cycles at each value of an axis, the largest peak first; empty if there are none, or if the
/// theory does not apply.
pub(super) fn predicted_cycles(
    document: &Document,
    axis: &DrawnAxis,
    values: &[f64],
    fixed: &[(String, Setting)],
) -> Vec<Vec<LimitCycle>> {
    let cycles = |&value: &f64| {
        let settings = fixed.iter().map(|(key, setting)| (key.as_str(), setting.clone()));
        let document = document.with(settings.chain([(axis.key.as_str(), Setting::Number(value))])).ok()?;
        limit_cycles(&document.scenario).ok()
    };
    values.par_iter().map(|value| cycles(value).unwrap_or_default()).collect()
}
