//! The bandwidth from the ideal loop to the loop as built, as a table.

use feeler_analysis::{Stage, Waterfall};

use crate::numbers::{percent, plain, with_unit};

/// Heads of the table's columns.
pub(crate) const HEADER: [&str; 6] = [
    "with",
    "stability limit",
    "edge (Hz)",
    "bandwidth at half of it (Hz)",
    "at half of the gain above (Hz)",
    "why it differs from the row above",
];
/// Columns of numbers.
pub(crate) const NUMBERS: [usize; 4] = [1, 2, 3, 4];
/// Smaller relative changes count as zero.
const SAME: f64 = 1e-3;

/// One row for each stage.
pub(crate) fn rows(waterfall: &Waterfall) -> Vec<Vec<String>> {
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), plain);
    let row = |i: usize| {
        let stage = &waterfall.stages[i];
        let why = why(stage, i.checked_sub(1).map(|before| &waterfall.stages[before]));
        let largest = match stage.largest_gain {
            None => {
                return vec![
                    stage.added.clone(),
                    "unbounded".into(),
                    "none".into(),
                    "no limit".into(),
                    "-".into(),
                    why,
                ];
            }
            Some(largest) if largest > 0.0 => plain(largest),
            Some(_) => "none".to_owned(),
        };
        let (bandwidth, kept) = (number(stage.bandwidth_hz), number(stage.bandwidth_at_gain_before_hz));
        vec![stage.added.clone(), largest, number(stage.edge_hz), bandwidth, kept, why]
    };
    (0..waterfall.stages.len()).map(row).collect()
}

/// The part of a stage's change that the ingredient causes directly, and the part due to the gain that it
/// allows. Also the end of a shelf beyond the bandwidth.
pub(crate) fn why(stage: &Stage, before: Option<&Stage>) -> String {
    let shelf = stage.shelf.map(|shelf| {
        format!(
            "integral action ends there: beyond, {} % is still followed, to {}",
            percent(shelf.share),
            with_unit(shelf.to_hz, "Hz")
        )
    });
    let change = before.and_then(|before| difference(stage, before));
    [change, shelf].into_iter().flatten().collect::<Vec<_>>().join("; ")
}

/// Why a stage's bandwidth differs from that of the previous one.
fn difference(stage: &Stage, before: &Stage) -> Option<String> {
    if stage.added == "saturation" {
        let reaches = before.bandwidth_hz.zip(stage.bandwidth_hz).is_some_and(|(before, own)| own < before);
        return Some(
            if reaches { "the limit is reached below the bandwidth" } else { "the limit is not reached" }
                .to_owned(),
        );
    }
    let (own_gain, gain_before) = (stage.largest_gain, before.largest_gain);
    match (own_gain, gain_before) {
        (None, None) => return None,
        (None, Some(_)) => return Some("every gain is stable".to_owned()),
        (Some(own), _) if own <= 0.0 => {
            return gain_before.is_none_or(|g| g > 0.0).then(|| "no gain is stable any more".to_owned());
        }
        (Some(_), None) => return Some("the first limit of the gain".to_owned()),
        (Some(_), Some(before)) if before <= 0.0 => return Some("some gains are stable now".to_owned()),
        _ => {}
    }
    let (own, former) = (stage.bandwidth_hz?, before.bandwidth_hz?);
    if (own / former - 1.0).abs() < SAME {
        return None;
    }
    let way = if own > former { "higher" } else { "lower" };
    let Some(kept) = stage.bandwidth_at_gain_before_hz else {
        return Some(format!("{way}: the gain above is unstable here"));
    };
    // In logarithms the change is the sum of the ingredient's effect at the same gain and the effect of the
    // changed gain.
    let (by_itself, by_gain) = ((kept / former).ln(), (own / kept).ln());
    let dominates = if by_itself.abs() > by_gain.abs() { "by itself" } else { "by the gain it allows" };
    let both = by_itself.abs().min(by_gain.abs()) > 0.1 * by_itself.abs().max(by_gain.abs());
    Some(format!("{way}, {}{dominates}", if both { "mostly " } else { "" }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_analysis::Shelf;

    fn stage(added: &str, largest_gain: f64, bandwidth_hz: f64, kept_hz: Option<f64>) -> Stage {
        Stage {
            added: added.into(),
            largest_gain: Some(largest_gain),
            edge_hz: Some(50.0),
            bandwidth_hz: Some(bandwidth_hz),
            bandwidth_at_gain_before_hz: kept_hz,
            shelf: None,
        }
    }

    #[test]
    fn truth_a_difference_is_said_to_be_of_the_ingredient_or_of_the_gain() {
        let before = stage("springs.a", 6.0, 100.0, None);
        assert_eq!(why(&stage("hold", 4.0, 60.0, Some(99.0)), Some(&before)), "lower, by the gain it allows");
        assert_eq!(why(&stage("hold", 5.9, 60.0, Some(62.0)), Some(&before)), "lower, by itself");
        assert_eq!(
            why(&stage("hold", 8.0, 140.0, Some(110.0)), Some(&before)),
            "higher, mostly by the gain it allows"
        );
        assert_eq!(
            why(&stage("hold", 2.0, 40.0, None), Some(&before)),
            "lower: the gain above is unstable here"
        );
        assert_eq!(why(&stage("hold", 6.0, 100.0, Some(100.0)), Some(&before)), "");
        let shelf = Some(Shelf { share: 0.57, to_hz: 64.0 });
        let ends = why(&Stage { shelf, ..stage("hold", 6.0, 100.0, Some(100.0)) }, Some(&before));
        assert_eq!(ends, "integral action ends there: beyond, 57.0 % is still followed, to 64 Hz");
    }
}
