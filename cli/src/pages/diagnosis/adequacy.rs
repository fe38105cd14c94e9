//! Remaining error of an answer at every horizon, and the reasons why it is not called explained.

use feeler_diagnosis::adequacy::{Adequacy, Horizon};

use crate::numbers::{fine_percent, percent};
use crate::pages::parts::Page;

/// The state of the machine with the accepted effects.
pub(crate) const WITH_EFFECTS: &str = "with the effects found";

/// The remaining error over every horizon.
pub(super) fn left(adequacy: &Adequacy) -> String {
    let share = |error: Option<f64>| {
        error.map_or_else(|| "an unknown share".into(), |error| format!("{} %", fine_percent(error)))
    };
    let of = |horizon: &Horizon| format!("{} of the signal over {}", share(horizon.after), horizon.name());
    let all: Vec<String> = adequacy.horizons.iter().map(of).collect();
    let floor = adequacy.horizons.first().map_or(0.0, Horizon::noise);
    format!("predictions are off by {}; noise alone leaves {} %", all.join(", by "), fine_percent(floor))
}

/// Reasons why the answer is not called explained, a sentence each.
pub(super) fn reasons(adequacy: &Adequacy) -> Vec<String> {
    adequacy
        .shortfalls
        .iter()
        .map(|shortfall| format!("Why not surer: {}.", shortfall.what.trim_end_matches('.')))
        .collect()
}

/// The table of errors by horizon, and the correlations of the missing force.
pub(super) fn add(page: &mut Page, adequacy: &Adequacy, is_found: bool) {
    if adequacy.horizons.is_empty() {
        return;
    }
    page.paragraph(
        "Errors by how far ahead predictions reach, in per cent of every channel's variation on the check \
         experiments:",
    );
    let cell = |error: Option<f64>| error.map_or_else(|| "not finite".into(), fine_percent);
    let rows: Vec<Vec<String>> = adequacy
        .horizons
        .iter()
        .map(|horizon| {
            let mut row = vec![horizon.name(), cell(horizon.before), cell(horizon.refit)];
            row.extend(is_found.then(|| cell(horizon.after)));
            row.push(fine_percent(horizon.noise()));
            row
        })
        .collect();
    let mut header = vec!["over", "machine as given", "after calibration"];
    header.extend(is_found.then_some(WITH_EFFECTS));
    header.push("noise floor");
    page.table(&header, &[1, 2, 3, 4][..header.len() - 1], &rows);
    if adequacy.residual.is_empty() || adequacy.drive_force_n == 0.0 {
        return;
    }
    page.paragraph(
        "What is left of the missing force. Each row is the part that depends on one quantity, beyond \
         chance, in per cent:",
    );
    let rows: Vec<Vec<String>> = adequacy
        .residual
        .iter()
        .map(|trace| {
            let share = |share: f64| percent(share.clamp(0.0, 1.0));
            vec![
                trace.goes_with.to_owned(),
                fine_percent(trace.rms_n / adequacy.drive_force_n),
                share(trace.share),
                share(trace.chance),
            ]
        })
        .collect();
    page.table(
        &["depends on", "of the drive's force", "of the missing variance", "by chance"],
        &[1, 2, 3],
        &rows,
    );
}
