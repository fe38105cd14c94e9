//! A diagnosis in plain words.

use feeler_diagnosis::report::{Cause, Diagnosis, Estimate, Verdict};

use super::apart::apart;
use crate::numbers::{percent, plain, with_unit};

/// Gaps below this many floors are nothing to close.
const NEAR_FLOOR: f64 = 1.05;

/// The sentence that matters most.
pub(crate) fn verdict(diagnosis: &Diagnosis) -> String {
    if diagnosis.contradictions.is_empty() {
        return cause(diagnosis);
    }
    format!("these records contradict each other, which must be mended first; taken as they are, {}", cause(diagnosis))
}

fn cause(diagnosis: &Diagnosis) -> String {
    let found: Vec<String> =
        diagnosis.effects.iter().filter(|effect| effect.accepted).map(|effect| format!("{} on {}", effect.kind, effect.on)).collect();
    let s = if found.len() == 1 { "s" } else { "" };
    let comes = if found.len() == 1 { "comes" } else { "come" };
    let leaves = if found.len() == 1 { "leaves" } else { "leave" };
    let found = found.join(" and ");
    let place = diagnosis.places.first().map_or("machine", |place| place.place);
    match diagnosis.verdict {
        Verdict::Explained => format!("the gap is explained by {found}."),
        Verdict::Ambiguous => match diagnosis.look_alikes.first() {
            Some([mine, other]) => format!("{found} explain{s} the gap, but these records cannot tell {mine} from {other}."),
            None => format!("{found} explain{s} the gap, but these records cannot tell what they see from its rivals."),
        },
        Verdict::UnknownCause if found.is_empty() => {
            format!("something is missing at the {place} that no effect of the library explains.")
        }
        Verdict::UnknownCause => {
            format!("{found} {comes} nearest, but {leaves} more than noise at the {place}: the real cause is another, or one more.")
        }
        Verdict::NoGap => "there is no gap: calibration within the stated tolerances explains the records.".into(),
        Verdict::NotIdentifiable if found.is_empty() => "the records excite the machine too little to tell.".into(),
        Verdict::NotIdentifiable => format!("{found} would do, but so would causes at other places: these records cannot tell."),
    }
}

/// Where the gap lies: the places of what was accepted, that of the largest credit first, or the most probable one; and how probable the least of them is.
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
    let of = |name: &&str| diagnosis.places.iter().find(|place| place.place == *name).map_or(0.0, |place| place.probability);
    (names.join(" and "), names.iter().map(of).fold(1.0, f64::min))
}

/// How far the gap closes.
pub(crate) fn closed(diagnosis: &Diagnosis) -> String {
    let gap = &diagnosis.gap;
    if gap.refit <= gap.floor * NEAR_FLOOR {
        let is_found = diagnosis.effects.iter().any(|effect| effect.accepted);
        let left = if is_found { "what was found is smaller than the noise, and shows in its pattern" } else { "no gap is left to close" };
        return format!("Calibration alone comes down to the noise floor: {left}.");
    }
    let [low, high] = gap.closed_ci90;
    let closed = percent(gap.closed);
    if low < high {
        let [low, high] = [low, high].map(|share| percent(share.max(0.0)));
        format!(
            "Of the gap that calibration leaves above the floor, {closed} % closes (90 % interval {low} to {high} %), on experiments that were never fitted."
        )
    } else {
        format!(
            "Of the gap that calibration leaves above the floor, {closed} % closes, on what was never fitted (one such experiment gives no interval)."
        )
    }
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
    cause.parameters.iter().map(|(name, value)| format!("{name} {}", estimate(value))).collect::<Vec<_>>().join(", ")
}

/// What follows from the answer, a sentence each.
pub(crate) fn advice(diagnosis: &Diagnosis) -> Vec<String> {
    let mut said: Vec<String> =
        diagnosis.contradictions.iter().map(|fault| format!("Do first: mend the records. {}", sentence(fault))).collect();
    match diagnosis.verdict {
        // What to do about the machine is known when the records agree.
        _ if !said.is_empty() => {}
        Verdict::Explained => {
            said.push("Do: simulate with machine.toml from here on, and look at the part named above on the real machine.".into());
        }
        Verdict::Ambiguous | Verdict::NotIdentifiable => said.push(match (&diagnosis.next_experiment, diagnosis.look_alikes.is_empty()) {
            (Some(_), _) => {
                "Do: make the experiment below and diagnose again; until then treat machine.toml as one of several that fit.".to_owned()
            }
            (None, true) => {
                "Do: record with more excitation and diagnose again; until then treat machine.toml as one of several that fit.".to_owned()
            }
            (None, false) => {
                "Do: simulate with machine.toml; it predicts what these records show as well as its rivals would, but do not rely on \
                              which of them is the cause before they are told apart."
                    .to_owned()
            }
        }),
        Verdict::UnknownCause => {
            said.push(
                "Do: look at the place named first and at the shape of the missing force there; no value in machine.toml mends it.".into(),
            );
        }
        Verdict::NoGap => said.push("Do: take the calibrated values of machine.toml; there is nothing to look for.".into()),
    }
    for [a, b] in &diagnosis.look_alikes {
        said.push(format!("To these records {a} and {b} look alike."));
        if diagnosis.next_experiment.is_none() {
            said.push(match apart(a, b) {
                Some(what) => format!("To tell {a} from {b}: {what}."),
                None => format!("No command of those known would separate {a} from {b}."),
            });
        }
    }
    for left in &diagnosis.left {
        said.push(format!("Left even so: {left}."));
    }
    if let Some(next) = &diagnosis.next_experiment {
        said.push(format!(
            "Next experiment: {} It separates {} from {}, with expected odds of {} to 1; the command is in next-experiment.csv.",
            sentence(&next.what),
            next.separates[0],
            next.separates[1],
            plain(next.expected_odds.min(1e6))
        ));
    }
    said
}

/// With a capital at its start and a stop at its end.
pub(crate) fn sentence(text: &str) -> String {
    let text = text.trim_end_matches('.');
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).chain(['.']).collect())
}
