//! Changes that a diagnosis makes in a machine file, with as many digits as the records support.

use feeler_diagnosis::Examination;
use feeler_diagnosis::report::Estimate;
use feeler_files::{Edit, rounded, with_numbers};

/// Smallest and largest number of digits of a fitted value. Errors of values that were fitted together
/// cancel, and rounding a delay to whole rows would move every command step past a reading.
const DIGITS: [usize; 2] = [5, 6];
/// Number of digits beyond the first uncertain one.
const SPARE: f64 = 2.0;

/// The changed and added numbers of the believed machine, rounded by their intervals.
pub(crate) fn edits(answer: &Examination) -> Vec<Edit> {
    let estimates = answer.diagnosis.effects.iter().filter(|effect| effect.accepted).flat_map(|effect| {
        let of = |name: &str| format!("{}.effects.{}.{name}", effect.on, effect.kind);
        effect.parameters.iter().map(move |(name, estimate)| (of(name), estimate))
    });
    let estimates: Vec<(String, &Estimate)> = estimates.collect();
    let changed = answer.difference.changed.iter().map(|changed| (changed.key.clone(), changed.new));
    let added = answer.difference.added.iter().flat_map(|added| {
        added.parameters.iter().map(|(name, value, _)| (format!("{}.{name}", added.key), *value))
    });
    let edit = |(key, value): (String, f64)| {
        let interval = estimates.iter().find(|(known, _)| *known == key).map(|(_, estimate)| estimate.ci90);
        let digits = interval.map_or(DIGITS[1], |interval| digits(value, interval));
        Edit { key, value: rounded(value, digits) }
    };
    changed.chain(added).map(edit).collect()
}

/// The text of a machine file with its fitted values rounded.
pub(crate) fn with_rounded(text: String, answer: &Examination) -> String {
    with_numbers(&text, &edits(answer)).unwrap_or(text)
}

/// Significant digits that an interval supports.
fn digits(value: f64, [low, high]: [f64; 2]) -> usize {
    let width = high - low;
    if !(width > 0.0 && width.is_finite()) || value == 0.0 {
        return DIGITS[1];
    }
    let known = (value.abs() / width).log10().ceil() + SPARE;
    known.clamp(DIGITS[0] as f64, DIGITS[1] as f64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_wide_interval_supports_few_digits() {
        assert_eq!(digits(7.6, [7.1, 8.2]), 5);
        assert_eq!(digits(7.6, [7.599, 7.601]), 6);
        assert_eq!(digits(7.6, [7.599_9, 7.600_1]), 6);
        assert_eq!(digits(7.6, [7.6, 7.6]), 6);
    }
}
