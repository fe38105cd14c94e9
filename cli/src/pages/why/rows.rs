//! Rows of the tables of an explanation, on its page and in the terminal.

use feeler_studies::run::Outcome;
use feeler_studies::why::{CheckedRemedy, Counterfactual, Explanation, Lift, Trial};

use crate::numbers::{percent, plain, with_unit};
use crate::units::Units;
use crate::words::judged_unit;

/// Largest number of listed alternatives to the chosen set.
const MOST_OTHERS: usize = 8;

/// Other sets of the chosen size that also remove the chatter: the changes and causes of the first ones, and
/// the number of further sets.
pub(crate) fn others(found: &Explanation) -> Vec<Vec<String>> {
    let others = found.smallest.get(1..).unwrap_or_default();
    let row = |set: &Vec<Counterfactual>| {
        let changes: Vec<&str> = set.iter().map(|change| change.words()).collect();
        let mut causes: Vec<&str> = set.iter().map(|change| change.cause().words()).collect();
        causes.dedup();
        vec![changes.join(" and "), causes.join(" and ")]
    };
    let mut rows: Vec<Vec<String>> = others.iter().take(MOST_OTHERS).map(row).collect();
    if others.len() > MOST_OTHERS {
        rows.push(vec![format!("and {} more, in why.json", others.len() - MOST_OTHERS), String::new()]);
    }
    rows
}

/// Without chatter: what would lift the limit of the gain, and to which factor on it.
pub(crate) fn lift_rows(found: &Explanation) -> Vec<Vec<String>> {
    let row = |lift: &Lift| {
        let to = lift.to.map_or_else(|| "no limit found".to_owned(), plain);
        vec![lift.change.words().to_owned(), plain(lift.from), to]
    };
    found.lifts.iter().map(row).collect()
}

/// Columns of these rows.
pub(crate) const LIFTS: [&str; 3] = ["with", "limit over gain now", "then"];

/// Changes that do not apply to this scenario, as a sentence.
pub(crate) fn untried(found: &Explanation) -> Option<String> {
    let left_out = found.singles.iter().filter(|trial| !trial.applies);
    let names: Vec<&str> = left_out.flat_map(|trial| &trial.changes).map(|change| change.words()).collect();
    (!names.is_empty()).then(|| format!("Does not apply here: {}.", names.join(", ")))
}

/// A row per run: its change and its outcome.
pub(crate) fn trial_rows(found: &Explanation, units: Units) -> Vec<Vec<String>> {
    let all = std::iter::once(&found.baseline).chain(&found.singles);
    let sets = found.contributions.iter().filter(|trial| trial.changes.len() > 1);
    all.chain(sets).filter(|trial| trial.applies).map(|trial| trial_row(trial, units)).collect()
}

fn trial_row(trial: &Trial, units: Units) -> Vec<String> {
    let changes: Vec<&str> = trial.changes.iter().map(|change| change.words()).collect();
    let name = if changes.is_empty() { "everything as it is".to_owned() } else { changes.join(" and ") };
    let outcome =
        trial.outcome.map_or_else(|| "could not be run".to_owned(), |outcome| outcome.words().to_owned());
    let decays = trial.cured && trial.outcome == Some(Outcome::Undecided);
    vec![
        name,
        if trial.only_by_period {
            "grows, less with the period".into()
        } else if decays {
            "decays slowly".into()
        } else {
            outcome
        },
        amplitude(trial, units).unwrap_or_else(|| "-".into()),
        trial.gain_margin.map_or_else(|| "-".into(), plain),
    ]
}

/// The amplitude of a sustained motion. Unbounded growth has none.
pub(super) fn amplitude(trial: &Trial, units: Units) -> Option<String> {
    if trial.outcome == Some(Outcome::Unstable) {
        Some("grows".into())
    } else {
        let unit = judged_unit(trial.controlled.as_deref(), units);
        trial.amplitude_n.map(|amplitude| with_unit(amplitude, unit))
    }
}

/// A row per remedy.
pub(crate) fn remedy_rows(found: &Explanation) -> Vec<Vec<String>> {
    let row = |(i, remedy): (usize, &CheckedRemedy)| {
        vec![
            format!("{} {}", i + 1, remedy.what),
            format!("{} %", percent(remedy.gain_factor)),
            remedy.bandwidth_hz.map_or_else(|| "-".into(), |hz| with_unit(hz, "Hz")),
            remedy.cost.map_or_else(|| "-".into(), than_now),
        ]
    };
    found.remedies.iter().enumerate().map(row).collect()
}

/// A cost in bandwidth, as a loss or a gain.
fn than_now(cost: f64) -> String {
    format!("{} % {}", percent(cost.abs()), if cost > 0.0 { "less" } else { "more" })
}

/// A row per remedy with settings: its number, and the command line arguments.
pub(crate) fn setting_rows(found: &Explanation) -> Vec<Vec<String>> {
    let settable = found.remedies.iter().enumerate().filter(|(_, remedy)| !remedy.settings.is_empty());
    settable
        .map(|(i, remedy)| {
            let sets: Vec<String> = remedy.settings.iter().map(|set| format!("--set {set}")).collect();
            vec![(i + 1).to_string(), sets.join(" ")]
        })
        .collect()
}
