//! Prediction errors by horizon. Short windows favour models that ignore the command; whole records penalise
//! models that ignore a force.

use serde::Serialize;

use super::criteria::Criteria;

/// Lengths of free windows, s. The first is the horizon of the gap.
pub(super) const WINDOWS_S: [f64; 3] = [0.05, 0.25, 1.0];

/// Root mean square prediction errors over the check experiments that are at least twice as long, each
/// relative to its channel's variation.
/// Predictions restart from the measured motion at the end of each horizon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Horizon {
    /// Length of each prediction, s; `None` for the free run over whole records.
    pub seconds: Option<f64>,
    /// Error of the machine as given. This and the other errors are `None` if the prediction is not finite.
    pub before: Option<f64>,
    /// Error of the calibrated machine; `None` if it is not finite.
    pub refit: Option<f64>,
    /// Error with the accepted effects; `None` if it is not finite.
    pub after: Option<f64>,
    /// Error that the noise of the channels alone leaves.
    pub floor: f64,
    /// Error that the noise of a measured command makes in a prediction this long.
    pub command_noise: f64,
}

/// The noise of a command is known to about this factor.
const NOISE_IS_KNOWN_TO: f64 = 1.2;

/// Noise that makes a fair part of a long prediction is known to about this factor: few of these are scored.
const LARGE_NOISE_IS_KNOWN_TO: f64 = 1.5;

/// All noise of a horizon is known to about this factor.
const FLOOR_IS_KNOWN_TO: f64 = 1.1;

impl Horizon {
    /// The length in words.
    pub fn name(&self) -> String {
        self.seconds.map_or_else(|| "the whole record".into(), |seconds| format!("{seconds} s"))
    }

    /// Error that all noise leaves.
    pub fn noise(&self) -> f64 {
        self.floor.hypot(self.command_noise)
    }

    /// The part of an error that the noise of a command does not make.
    pub(super) fn beyond(&self, error: f64) -> f64 {
        (error.powi(2) - (NOISE_IS_KNOWN_TO * self.command_noise).powi(2)).max(0.0).sqrt()
    }
}

/// Describes the error of short predictions of a machine without a cause. Such an answer says that the
/// machine is right, so its errors must be slight or due to noise. One believed value at its limit may be a
/// little beyond; two at once are no chance (`limits` counts them).
pub(super) fn beyond_noise(horizons: &[Horizon], limits: usize, criteria: &Criteria) -> Option<String> {
    let shortest = horizons.first()?;
    let least = if limits == 1 { criteria.most_left } else { criteria.slight };
    let most = (criteria.most_floors * shortest.noise()).max(least);
    shortest.after.filter(|after| *after > most).map(|after| short_error(shortest, after))
}

fn short_error(shortest: &Horizon, after: f64) -> String {
    format!(
        "short predictions are off by {} of the signal, beside a noise floor of {}",
        share(after),
        share(shortest.noise())
    )
}

/// Describes remaining errors that are large against both noise and signal. Where forces balance, short
/// predictions do not count, because the noise of the command dominates them. Those without a cause are
/// tested by [`beyond_noise`].
pub(super) fn left(
    horizons: &[Horizon],
    [refitted, missing]: [f64; 2],
    drive_force: f64,
    [is_found, is_balanced]: [bool; 2],
    criteria: &Criteria,
) -> Vec<String> {
    let mut found = Vec::new();
    if let Some(shortest) = horizons.first() {
        let most = (criteria.most_floors * shortest.floor).max(criteria.most_left);
        match shortest.after {
            None => found.push("the repaired machine's prediction is not finite".into()),
            Some(after) if is_found && !is_balanced && shortest.beyond(after) > most => {
                found.push(short_error(shortest, after));
            }
            Some(_) => {}
        }
    }
    let hardly_fell = !is_found || missing > criteria.most_of_missing_force * refitted;
    if missing > criteria.most_missing_force * drive_force && hardly_fell {
        found.push(format!(
            "a force of {} of the drive's is still missing, against {} after calibration alone",
            share(missing / drive_force),
            share(refitted / drive_force)
        ));
    }
    found
}

/// Whether the calibrated machine's errors are small against the signal at every horizon of up to a second.
/// The shortest one alone does not show that.
pub(super) fn are_slight(horizons: &[Horizon], criteria: &Criteria) -> bool {
    let most = |seconds: f64| if seconds > WINDOWS_S[0] { criteria.slight_far } else { criteria.slight };
    let mut ahead = ahead(horizons).filter_map(|horizon| Some((horizon.seconds?, horizon.refit)));
    reach_far(horizons) && ahead.all(|(seconds, refit)| refit.is_some_and(|refit| refit <= most(seconds)))
}

/// Whether the accepted machine's errors are small against noise and signal at every horizon of up to a
/// second.
pub(super) fn are_fair(horizons: &[Horizon], criteria: &Criteria) -> bool {
    let is_fair = |horizon: &Horizon| {
        let near = horizon.seconds <= Some(WINDOWS_S[0]);
        horizon.after.map(|after| horizon.beyond(after)).is_some_and(|after| {
            after < criteria.most_left && (!near || after < criteria.most_floors * horizon.floor)
        })
    };
    reach_far(horizons) && ahead(horizons).all(is_fair)
}

/// The horizons of up to a second.
fn ahead(horizons: &[Horizon]) -> impl Iterator<Item = &Horizon> {
    horizons.iter().filter(|horizon| horizon.seconds.is_some())
}

/// Whether a horizon of up to a second is longer than the shortest one, which shows little of a slow motion.
fn reach_far(horizons: &[Horizon]) -> bool {
    horizons.iter().any(|horizon| horizon.seconds > Some(WINDOWS_S[0]))
}

/// Whether a repaired machine removes at least [`Criteria::least_closed`] of the calibrated one's error, at
/// every horizon of up to a second.
pub(super) fn are_better(horizons: &[Horizon], criteria: &Criteria) -> bool {
    let is_better = |horizon: &Horizon| {
        let errors = horizon.after.zip(horizon.refit);
        errors.is_some_and(|(after, refit)| after < (1.0 - criteria.least_closed) * refit)
    };
    reach_far(horizons) && ahead(horizons).all(is_better)
}

/// Describes the shortest horizon of up to a second at which predictions lose the motion, if noise alone does
/// not. An error of the size that noise makes does not count, even if both are large.
pub(super) fn lost(horizons: &[Horizon], criteria: &Criteria) -> Option<String> {
    let is_lost = |horizon: &&Horizon| {
        let is_known = horizon.noise() < criteria.lost;
        let most = (criteria.most_floors * horizon.floor).max(criteria.most_left_far);
        horizon.seconds.is_some()
            && is_known
            && horizon.after.is_some_and(|after| {
                horizon.beyond(after) > most && after > LARGE_NOISE_IS_KNOWN_TO * horizon.noise()
            })
    };
    let lost = horizons.iter().find(is_lost)?;
    Some(format!("over {} predictions are off by {} of the signal", lost.name(), share(lost.after?)))
}

/// Describes a gap of which the causes remove too little beyond the floor.
pub(super) fn unclosed(closed: f64, criteria: &Criteria) -> Option<String> {
    (closed < criteria.least_closed).then(|| {
        let removed = if closed > 0.0 { format!("only {}", share(closed)) } else { "none".to_owned() };
        format!("the effects found remove {removed} of the error beyond the noise floor")
    })
}

/// Describes a gap of which the causes leave a part even if they remove the share `most`, the upper end of
/// its interval.
pub(super) fn partly_closed(most: f64, criteria: &Criteria) -> Option<String> {
    (most < criteria.well_closed).then(|| {
        let left = share(1.0 - most.max(0.0));
        format!("{left} or more of the error beyond the noise floor remains: there may be a further cause")
    })
}

/// Horizons at which the repaired machine predicts worse than the calibrated one, in words, each with whether
/// the error is small nevertheless.
pub(super) fn worsened(horizons: &[Horizon], criteria: &Criteria) -> Vec<(bool, String)> {
    let is_worse = |horizon: &&Horizon| match (horizon.refit, horizon.after) {
        (None, _) => false,
        (Some(_), None) => true,
        (Some(refit), Some(after)) => {
            // If both have lost the motion, only a prediction that is far worse counts.
            let times = if refit > criteria.lost { LOST_FURTHER } else { criteria.most_worsening };
            after > times * refit && after > FLOOR_IS_KNOWN_TO * horizon.noise()
        }
    };
    let say = |horizon: &Horizon| {
        let of = |error: Option<f64>| error.map_or_else(|| "no finite error".into(), share);
        let is_little = horizon
            .after
            .zip(horizon.refit)
            .is_some_and(|(after, refit)| after < criteria.most_left && after < LOST_FURTHER * refit);
        let what = format!(
            "over {} the repaired machine is off by {}, the calibrated one by {}",
            horizon.name(),
            of(horizon.after),
            of(horizon.refit)
        );
        (is_little, what)
    };
    horizons.iter().filter(is_worse).map(say).collect()
}

/// A prediction counts as far worse at this ratio to an error that is small or has lost the motion.
const LOST_FURTHER: f64 = 3.0;
/// Larger shares are not printed as numbers.
const MOST_SHARE: f64 = 10.0;

/// Smaller shares get more digits, %.
const LEAST_PERCENT: f64 = 0.1;

/// A share in percent, or a bound if its number would be meaningless.
pub(super) fn share(value: f64) -> String {
    match 100.0 * value {
        percent if percent > 100.0 * MOST_SHARE => "more than 1000 %".into(),
        percent if percent > 0.0 && percent < LEAST_PERCENT => format!("{percent:.3} %"),
        percent => format!("{percent:.1} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn horizon(refit: f64, after: f64) -> Horizon {
        Horizon {
            seconds: Some(1.0),
            before: Some(refit),
            refit: Some(refit),
            after: Some(after),
            floor: 0.01,
            command_noise: 0.0,
        }
    }

    #[test]
    fn truth_a_repair_that_is_worse_far_ahead_is_told() {
        let criteria = Criteria::default();
        assert!(worsened(&[horizon(0.5, 0.1), horizon(0.8, 0.5)], &criteria).is_empty());
        assert_eq!(worsened(&[horizon(0.5, 0.1), horizon(0.5, 0.7)], &criteria).len(), 1);
        // The repaired machine must be better, unless noise alone leaves such an error.
        assert_eq!(worsened(&[horizon(0.50, 0.52)], &criteria).len(), 1);
        let noisy = Horizon { floor: 0.5, ..horizon(0.50, 0.52) };
        assert!(worsened(&[noisy], &criteria).is_empty());
        // Both have lost the motion; then one diverges.
        assert!(worsened(&[horizon(2.0, 2.5)], &criteria).is_empty());
        assert_eq!(worsened(&[horizon(2.0, 1e14)], &criteria).len(), 1);
        // Differences within noise do not count.
        assert!(worsened(&[horizon(0.008, 0.0105)], &criteria).is_empty());
        let lost = Horizon { after: None, ..horizon(0.5, 0.1) };
        assert_eq!(worsened(&[lost], &criteria).len(), 1);
        let of = |refit, after| worsened(&[horizon(refit, after)], &criteria)[0].0;
        assert!(of(0.02, 0.04) && !of(0.04, 0.08) && !of(0.004, 0.04));
    }

    #[test]
    fn truth_a_machine_is_better_or_fair_where_it_is_so_up_to_a_second() {
        let criteria = Criteria::default();
        let free = Horizon { seconds: None, ..horizon(0.5, 3.0) };
        assert!(are_better(&[horizon(0.2, 0.09), free], &criteria));
        assert!(!are_better(&[horizon(0.2, 0.09), horizon(0.2, 0.11)], &criteria));
        let near = |after| Horizon { seconds: Some(WINDOWS_S[0]), ..horizon(after, after) };
        assert!(are_fair(&[near(0.03), horizon(0.049, 0.049), free], &criteria));
        assert!(!are_fair(&[near(0.045), horizon(0.04, 0.04)], &criteria));
        assert!(!are_fair(&[near(0.03), horizon(0.1, 0.1)], &criteria));
        // Only the shortest horizon is known.
        assert!(!are_fair(&[near(0.03), free], &criteria) && !are_fair(&[], &criteria));
    }

    #[test]
    fn truth_a_rest_is_slight_where_it_is_so_at_every_horizon() {
        let criteria = Criteria::default();
        let [near, far] =
            [0.05, 1.0].map(|seconds| Horizon { seconds: Some(seconds), ..horizon(0.004, 0.004) });
        let free = Horizon { seconds: None, ..horizon(0.9, 0.9) };
        assert!(are_slight(&[near, far, free], &criteria));
        assert!(!are_slight(&[near, Horizon { refit: Some(0.05), ..far }], &criteria));
        assert!(!are_slight(&[Horizon { refit: Some(0.01), ..near }, far], &criteria));
        assert!(!are_slight(&[near, Horizon { refit: None, ..far }], &criteria));
        assert!(!are_slight(&[near], &criteria) && !are_slight(&[free], &criteria));
    }

    #[test]
    fn truth_what_is_left_counts_against_noise_signal_and_drive() {
        let criteria = Criteria::default();
        let told = |after: f64, missing: [f64; 2]| {
            left(&[horizon(0.9, after)], missing, 10.0, [true, false], &criteria).len()
        };
        assert_eq!(told(0.03, [5.0, 0.5]), 0);
        assert_eq!(told(0.81, [5.0, 0.5]), 1);
        // A machine without a cause is right up to noise only.
        let without = |after: f64| {
            let horizons = [Horizon { floor: 0.002, ..horizon(after, after) }];
            let [none, found] =
                [false, true].map(|found| left(&horizons, [0.0; 2], 10.0, [found, false], &criteria).len());
            assert_eq!(none, 0);
            let of = |limits| usize::from(beyond_noise(&horizons, limits, &criteria).is_some());
            [of(0), of(1), of(2), found]
        };
        assert_eq!(without(0.007), [0; 4]);
        assert_eq!(without(0.03), [1, 0, 1, 0]);
        assert_eq!(without(0.06), [1; 4]);
        // Most of the force is explained, or hardly any of it.
        assert_eq!(told(0.03, [50.0, 3.0]), 0);
        assert_eq!(told(0.03, [4.0, 3.0]), 1);
        assert_eq!(
            lost(&[horizon(0.9, 0.2), Horizon { seconds: None, ..horizon(2.0, 0.9) }], &criteria),
            None
        );
        let unstable = Horizon { command_noise: 2.0, ..horizon(0.9, 8.0) };
        assert_eq!(lost(&[unstable], &criteria), None);
        let noisy =
            |after| lost(&[Horizon { command_noise: 0.5, ..horizon(0.9, after) }], &criteria).is_some();
        assert!(!noisy(0.72) && noisy(1.2));
        assert!(lost(&[horizon(0.9, 0.8)], &criteria).is_some_and(|told| told.contains("80.0 %")));
        assert_eq!(unclosed(0.9, &criteria), None);
        assert!(unclosed(0.16, &criteria).is_some_and(|told| told.contains("16.0 %")));
        assert_eq!(partly_closed(0.8, &criteria), None);
        assert!(partly_closed(0.7, &criteria).is_some_and(|told| told.contains("30.0 % or more")));
        assert_eq!(share(1e24), "more than 1000 %");
    }
}
