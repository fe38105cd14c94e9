//! A diagnosis in plain words.

use feeler_diagnosis::adequacy::Condition;
use feeler_diagnosis::report::{Attempt, AttemptOutcome, Cause, Diagnosis, Estimate, Verdict};

use super::adequacy;
use crate::numbers::{percent, plain, with_unit};

/// Number of noise floors below which a gap counts as closed.
const NEAR_FLOOR: f64 = 1.05;

/// The most important sentence.
pub(crate) fn verdict(diagnosis: &Diagnosis) -> String {
    let left = sentence(&adequacy::left(&diagnosis.adequacy.horizons));
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
            None if is_only_early(diagnosis) => {
                format!(
                    "{found} explain{s} the gap, but the time ended before all causes were tried to the end."
                )
            }
            None => format!(
                "{found} explain{s} the gap, but these records cannot separate the cause from its rivals."
            ),
        },
        Verdict::UnknownCause if found.is_empty() => {
            let is_tried = |attempt: &&Attempt| {
                !matches!(attempt.why, AttemptOutcome::NotTried | AttemptOutcome::Unfinished)
            };
            let (tried, all) = (diagnosis.attempts.iter().filter(is_tried).count(), diagnosis.attempts.len());
            if tried == all {
                format!("no cause of the library explains the gap, which points to the {place}.")
            } else {
                format!(
                    "no cause that was tried explains the gap, which points to the {place}; {} of {all} \
                     causes were not tried to the end: the time ran out.",
                    all - tried
                )
            }
        }
        Verdict::UnknownCause if diagnosis.adequacy.has_untried() => {
            format!(
                "{found} {comes} nearest so far, but {leaves} more than noise at the {place}: the time ended \
                 before all causes were tried to the end."
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
        Verdict::NotIdentifiable if diagnosis.adequacy.is_doubted() => format!(
            "calibration within the stated tolerances explains the records, but {}a cause may be hidden{}.",
            if diagnosis.adequacy.may_hide_cause() { "" } else { "with a doubtful value: " },
            diagnosis.places.first().map_or_else(String::new, |first| format!(" at the {}", first.place))
        ),
        Verdict::NotIdentifiable if found.is_empty() => {
            "the records excite the machine too little for a diagnosis.".into()
        }
        Verdict::NotIdentifiable => {
            format!("{found} would explain the gap, but so would causes at other places.")
        }
    }
}

/// Whether believed values at the limits of their tolerances are the only doubt.
pub(super) fn is_limited(diagnosis: &Diagnosis) -> bool {
    let shortfalls = &diagnosis.adequacy.shortfalls;
    let is_of_tolerance = |condition: Condition| condition == Condition::Tolerance;
    !has_rival(diagnosis)
        && !shortfalls.is_empty()
        && shortfalls.iter().all(|shortfall| is_of_tolerance(shortfall.condition))
}

/// Whether causes were left untried, and none of those that were tried is a rival.
pub(super) fn is_only_early(diagnosis: &Diagnosis) -> bool {
    let is_rival = |condition: Condition| condition == Condition::Rivals;
    diagnosis.adequacy.has_untried()
        && !has_rival(diagnosis)
        && !diagnosis.adequacy.shortfalls.iter().any(|shortfall| is_rival(shortfall.condition))
}

fn has_rival(diagnosis: &Diagnosis) -> bool {
    !diagnosis.look_alikes.is_empty() || diagnosis.effects.iter().any(|effect| !effect.accepted)
}

/// Whether an answer without a gap leaves an error that is too small to name its cause.
pub(super) fn is_slight(diagnosis: &Diagnosis) -> bool {
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
        (false, false) if diagnosis.verdict == Verdict::NoGap => {
            return "What calibration leaves above the noise floor is too little to name a cause.".into();
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

/// The records do not determine a value if the upper end of its interval is this many times as large.
const UNDETERMINED: f64 = 100.0;

/// The interval of a value; `None` if the value is fixed.
pub(super) fn interval(estimate: &Estimate) -> Option<String> {
    let [low, high] = estimate.ci90;
    let is_undetermined = low >= 0.0 && estimate.value > 0.0 && high > UNDETERMINED * estimate.value;
    let of = |end: f64| with_unit(end, unit(estimate));
    match (high > low, is_undetermined || !low.is_finite() || !high.is_finite()) {
        (false, _) => None,
        (true, true) => Some("not determined".into()),
        (true, false) => Some(format!("{} to {}", of(low), of(high))),
    }
}

fn unit(estimate: &Estimate) -> &str {
    if estimate.unit == "1" { "" } else { &estimate.unit }
}

/// A value with its interval.
pub(crate) fn estimate(estimate: &Estimate) -> String {
    let value = with_unit(estimate.value, unit(estimate));
    interval(estimate).map_or_else(|| value.clone(), |interval| format!("{value} ({interval})"))
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
    fn truth_an_interval_far_above_its_value_is_no_interval() {
        let of = |value: f64, ci90: [f64; 2]| estimate(&Estimate { value, ci90, unit: "m/s".into() });
        assert_eq!(of(0.01, [f64::MIN_POSITIVE, 1000.0]), "10 mm/s (not determined)");
        assert_eq!(of(0.01, [0.005, 0.015]), "10 mm/s (5 mm/s to 15 mm/s)");
        assert_eq!(of(0.01, [-3.0, 3.0]), "10 mm/s (-3 m/s to 3 m/s)");
        assert_eq!(of(0.01, [0.01, 0.01]), "10 mm/s");
    }
}
