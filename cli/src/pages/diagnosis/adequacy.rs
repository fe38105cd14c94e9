//! Remaining error of an answer at every horizon, and the reasons why it is not called explained.

use feeler_diagnosis::adequacy::{Adequacy, Horizon};

use crate::numbers::{fine_percent, percent};
use crate::pages::parts::Page;

/// The state of the machine with the accepted effects.
pub(crate) const WITH_EFFECTS: &str = "with the effects found";

/// The remaining error over every horizon.
pub(super) fn left(horizons: &[Horizon]) -> String {
    let share = |error: Option<f64>| {
        error.map_or_else(|| "an unknown share".into(), |error| format!("{} %", fine_percent(error)))
    };
    let of = |(i, horizon): (usize, &Horizon)| {
        let of_what = if i == 0 { " of the signal" } else { "" };
        let noise = fine_percent(horizon.noise());
        format!("{}{of_what} over {} (noise alone {noise} %)", share(horizon.after), horizon.name())
    };
    let all: Vec<String> = horizons.iter().enumerate().map(of).collect();
    format!("predictions are off by {}", all.join(", by "))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_the_error_and_the_noise_of_every_horizon_are_stated() {
        let horizon = |seconds, after, floor, command_noise| Horizon {
            seconds,
            before: None,
            refit: None,
            after,
            floor,
            command_noise,
        };
        let horizons = [horizon(Some(0.05), Some(0.012), 3e-3, 4e-3), horizon(None, None, 3e-3, 0.0)];
        assert_eq!(
            left(&horizons),
            "predictions are off by 1.2 % of the signal over 0.05 s (noise alone 0.5 %), by an unknown share \
             over the whole record (noise alone 0.3 %)"
        );
    }
}
