//! A diagnosis in plain words.

use feeler_diagnosis::adequacy::Condition;
use feeler_diagnosis::apart;
use feeler_diagnosis::report::{Attempt, AttemptOutcome, Cause, Diagnosis, Estimate, MOST_ODDS, Verdict};

use super::adequacy;
use crate::numbers::{percent, plain, with_unit};

/// Number of noise floors below which a gap counts as closed.
const NEAR_FLOOR: f64 = 1.05;

/// The most important sentence.
pub(crate) fn verdict(diagnosis: &Diagnosis) -> String {
    let left = sentence(&adequacy::left(&diagnosis.adequacy));
    if diagnosis.contradictions.is_empty() {
        return format!("{} {left}", cause(diagnosis));
    }
    format!(
        "these records contradict each other and must be corrected first; as they are, {} {left}",
        cause(diagnosis)
    )
}

fn cause(diagnosis: &Diagnosis) -> String {
    let found: Vec<String> = diagnosis
        .effects
        .iter()
        .filter(|effect| effect.accepted)
        .map(|effect| format!("{} on {}", effect.kind, effect.on))
        .collect();
    let s = if found.len() == 1 { "s" } else { "" };
    let comes = if found.len() == 1 { "comes" } else { "come" };
    let leaves = if found.len() == 1 { "leaves" } else { "leave" };
    let found = found.join(" and ");
    let place = diagnosis.places.first().map_or("machine", |place| place.place);
    match diagnosis.verdict {
        Verdict::Explained => format!("the gap is explained by {found}."),
        Verdict::Ambiguous => match diagnosis.look_alikes.first() {
            Some([mine, other]) => {
                format!("{found} explain{s} the gap, but these records cannot separate {mine} from {other}.")
            }
            None if is_limited(diagnosis) => {
                format!("{found} explain{s} the gap beside a believed value at the limit of its tolerance.")
            }
            None => format!(
                "{found} explain{s} the gap, but these records cannot separate the cause from its rivals."
            ),
        },
        Verdict::UnknownCause if found.is_empty() => {
            let is_tried = |attempt: &&Attempt| !matches!(attempt.why, AttemptOutcome::NotTried);
            let (tried, all) = (diagnosis.attempts.iter().filter(is_tried).count(), diagnosis.attempts.len());
            if tried == all {
                format!("no cause of the library explains the gap, which points to the {place}.")
            } else {
                format!(
                    "no cause that was tried explains the gap, which points to the {place}; {} of {all} \
                     causes were not tried: the time ran out.",
                    all - tried
                )
            }
        }
        Verdict::UnknownCause if diagnosis.adequacy.has_untried() => {
            format!(
                "{found} {comes} nearest so far, but {leaves} more than noise at the {place}: the time ended \
                 before all causes were tried."
            )
        }
        Verdict::UnknownCause => {
            format!(
                "{found} {comes} nearest, but {leaves} more than noise at the {place}: the real cause is \
                 another, or there is a further one."
            )
        }
        Verdict::NoGap if is_slight(diagnosis) => {
            "there is no gap to speak of: calibration within the stated tolerances leaves too little to name \
             a cause of it."
                .into()
        }
        Verdict::NoGap => {
            "there is no gap: calibration within the stated tolerances explains the records.".into()
        }
        Verdict::NotIdentifiable if found.is_empty() => {
            "the records excite the machine too little for a diagnosis.".into()
        }
        Verdict::NotIdentifiable => {
            format!("{found} would explain the gap, but so would causes at other places.")
        }
    }
}

/// Whether believed values at the limits of their tolerances are the only doubt.
fn is_limited(diagnosis: &Diagnosis) -> bool {
    let shortfalls = &diagnosis.adequacy.shortfalls;
    let has_rival =
        !diagnosis.look_alikes.is_empty() || diagnosis.effects.iter().any(|effect| !effect.accepted);
    let is_of_tolerance = |condition: Condition| condition == Condition::Tolerance;
    !has_rival
        && !shortfalls.is_empty()
        && shortfalls.iter().all(|shortfall| is_of_tolerance(shortfall.condition))
}

/// Whether an answer without a gap leaves an error that is too small to name its cause.
fn is_slight(diagnosis: &Diagnosis) -> bool {
    let is_rest = |condition| matches!(condition, Condition::Left | Condition::Residual);
    diagnosis.adequacy.shortfalls.iter().any(|shortfall| is_rest(shortfall.condition))
}

/// Location of the gap: the places of the accepted causes, largest credit first, or the most probable place.
/// The number is the probability of the least probable of them.
pub(crate) fn places(diagnosis: &Diagnosis) -> (String, f64) {
    let mut accepted: Vec<&Cause> = diagnosis.effects.iter().filter(|effect| effect.accepted).collect();
    accepted.sort_by(|a, b| b.credit.total_cmp(&a.credit));
    let mut names: Vec<&str> = accepted.iter().map(|effect| effect.place).collect();
    if diagnosis.verdict == Verdict::UnknownCause || names.is_empty() {
        names = diagnosis.places.first().map(|place| place.place).into_iter().collect();
    }
    let mut seen: Vec<&str> = Vec::new();
    names.retain(|name| {
        !seen.contains(name) && {
            seen.push(name);
            true
        }
    });
    let of = |name: &&str| {
        diagnosis.places.iter().find(|place| place.place == *name).map_or(0.0, |place| place.probability)
    };
    (names.join(" and "), names.iter().map(of).fold(1.0, f64::min))
}

/// Whether any cause was accepted.
pub(crate) fn is_found(diagnosis: &Diagnosis) -> bool {
    diagnosis.effects.iter().any(|effect| effect.accepted)
}

/// Share of the gap that is closed, as scored on `checks` experiments.
pub(crate) fn closed(diagnosis: &Diagnosis, checks: usize) -> String {
    let gap = &diagnosis.gap;
    let is_at_floor = gap.refit <= gap.floor * NEAR_FLOOR;
    match (is_at_floor, is_found(diagnosis)) {
        (true, true) => {
            return "Over all channels the errors after calibration alone are already of the size of the \
                    noise. The effects found show in their pattern."
                .into();
        }
        (true, false) => {
            return "Calibration alone reaches the noise floor: no gap is left.".into();
        }
        (false, false) => {
            return "No accepted effect closes the gap that calibration leaves above the floor.".into();
        }
        (false, true) => {}
    }
    if gap.closed <= 0.0 {
        return format!(
            "On the check experiments, the effects remove none of the error that calibration leaves above \
             the floor in short predictions: it rises by {} %.",
            percent(-gap.closed)
        );
    }
    let closed = percent(gap.closed);
    let [low, high] = gap.closed_ci90;
    let interval = if low < high {
        let [low, high] = [low, high].map(|share| percent(share.max(0.0)));
        format!(" (90 % interval {low} to {high} %)")
    } else if checks == 1 {
        " (one such experiment gives no interval)".into()
    } else {
        String::new()
    };
    format!(
        "On the check experiments, the effects remove {closed} % of the error that calibration leaves above \
         the floor{interval}."
    )
}

/// A frequency band.
pub(crate) fn band([low, high]: [f64; 2]) -> String {
    format!("{} to {} Hz", plain(low), plain(high))
}

/// A value with its interval.
pub(crate) fn estimate(estimate: &Estimate) -> String {
    let unit = if estimate.unit == "1" { "" } else { estimate.unit.as_str() };
    let [low, high] = estimate.ci90;
    if high <= low || !low.is_finite() || !high.is_finite() {
        return with_unit(estimate.value, unit);
    }
    format!("{} ({} to {})", with_unit(estimate.value, unit), with_unit(low, unit), with_unit(high, unit))
}

/// All parameters of a cause.
pub(crate) fn parameters(cause: &Cause) -> String {
    cause
        .parameters
        .iter()
        .map(|(name, value)| format!("{name} {}", estimate(value)))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Recommendations from the answer.
pub(crate) struct Advice {
    /// Steps to take, in this order; a sentence or two each.
    pub(crate) steps: Vec<String>,
    /// Limits of the answer, a sentence each.
    pub(crate) remarks: Vec<String>,
}

impl Advice {
    pub(crate) fn of(diagnosis: &Diagnosis) -> Self {
        let correct = |fault: &String| format!("Correct the records: {fault}.");
        let mut steps: Vec<String> = diagnosis.contradictions.iter().map(correct).collect();
        if !steps.is_empty() {
            steps.push("Diagnose again. Only if the corrected records agree, do what follows.".into());
        }
        steps.extend(to_do(diagnosis));
        let mut remarks = adequacy::reasons(&diagnosis.adequacy);
        for [a, b] in &diagnosis.look_alikes {
            if diagnosis.verdict == Verdict::UnknownCause {
                remarks.push(format!(
                    "{a} and {b} look alike in these records. Neither explains them, so separating them \
                     would not find the cause."
                ));
                continue;
            }
            remarks.push(format!("{a} and {b} look alike in these records."));
            if diagnosis.next_experiment.is_none() {
                match apart(*a, *b) {
                    Some(what) => steps.push(format!("To separate {a} from {b}, {what}.")),
                    None => remarks.push(format!(
                        "No known command separates {a} from {b} within the travel and speed of these \
                         records."
                    )),
                }
            }
        }
        remarks.extend(diagnosis.left.iter().map(|left| format!("Still unexplained: {left}.")));
        if let Some(next) = &diagnosis.next_experiment {
            steps.push(format!(
                "Next experiment: {} It separates {} from {}, with expected odds of {}; the command is in \
                 next-experiment.csv.",
                sentence(&next.what),
                next.separates[0],
                next.separates[1],
                odds(next.expected_odds)
            ));
        }
        Self { steps, remarks }
    }
}

/// Recommendations for the machine.
fn to_do(diagnosis: &Diagnosis) -> Vec<String> {
    let words = match diagnosis.verdict {
        Verdict::Explained => {
            let found = diagnosis.effects.iter().filter(|effect| effect.accepted);
            let inspect = |cause: &Cause| {
                format!(
                    "On the real machine, inspect {} for {}, {}.",
                    cause.on,
                    cause.kind,
                    parameters(cause)
                )
            };
            let simulate = "Simulate with the repaired machine.toml.".to_owned();
            return std::iter::once(simulate).chain(found.map(inspect)).collect();
        }
        Verdict::Ambiguous if is_limited(diagnosis) => {
            "Correct the believed value named below, or state a wider tolerance, and diagnose again."
        }
        Verdict::Ambiguous | Verdict::NotIdentifiable => {
            match (&diagnosis.next_experiment, diagnosis.look_alikes.is_empty()) {
                (Some(_), _) => {
                    "Run the experiment below and diagnose again. Until then machine.toml is one of several \
                     that fit."
                }
                (None, true) => {
                    "Record with more excitation and diagnose again. Until then machine.toml is one of \
                     several that fit."
                }
                (None, false) => {
                    "Simulate with machine.toml: it predicts these records as well as its rivals would. Do \
                     not rely on its cause before an experiment separates them."
                }
            }
        }
        Verdict::UnknownCause if diagnosis.adequacy.has_untried() => {
            "Diagnose again with a larger --budget, or with --budget unlimited. Until then do not rely on a \
             cause."
        }
        Verdict::UnknownCause => {
            "Inspect the first place and the shape of the missing force there. No value in the machine file \
             removes it."
        }
        Verdict::NoGap if is_slight(diagnosis) => "Use the calibrated values of machine.toml.",
        Verdict::NoGap => "Use the calibrated values of machine.toml. There is no further cause to find.",
    };
    let table = diagnosis.table.as_ref().map(|table| {
        format!(
            "Until the cause is known, simulate with machine.toml. A table of the force over {} on {} stands \
             in for it, and closes {} % of the gap on the check experiments.",
            table.over,
            table.on,
            percent(table.closed)
        )
    });
    std::iter::once(words.to_owned()).chain(table).collect()
}

/// Odds against one, capped at a million.
fn odds(odds: f64) -> String {
    if odds >= MOST_ODDS { "more than a million to 1".into() } else { format!("{} to 1", plain(odds)) }
}

/// The text with a capital letter at its start and a full stop at its end.
pub(crate) fn sentence(text: &str) -> String {
    let text = text.trim_end_matches('.');
    let mut letters = text.chars();
    letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().chain(letters).chain(['.']).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_odds_that_are_cut_off_are_no_figure() {
        assert_eq!(odds(1e6), "more than a million to 1");
        assert_eq!(odds(12.5), "12.5 to 1");
    }
}
