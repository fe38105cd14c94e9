//! Conditions that an answer must meet to be called explained, judged apart from the ranking that found it.
//!
//! A ranking finds the best of the causes that were tried. This module decides whether the best is good
//! enough. It measures the error at every horizon and tests whether the error still depends on a known
//! quantity. It also tests whether every value is plausible, and whether another place would explain as much.

mod ahead;
mod assess;
mod balance;
mod criteria;
mod held;
mod horizons;
mod plausible;
mod residual;
mod rivals;
mod tolerance;

pub(crate) use ahead::worsens;
pub(crate) use assess::{Sizes, assess};
pub(crate) use balance::{as_good, further};
pub use criteria::Criteria;
pub use horizons::Horizon;
pub use residual::ResidualTrace;
pub(crate) use rivals::as_good_but_small;
pub(crate) use tolerance::{Doubt, Doubted};

use feeler_plant::effects::Place;
use serde::Serialize;

use crate::gap::unknown::{ADEQUATE, in_sigmas};

/// Factor on the usual limit of a column's mean square residual if the residual depends on no known quantity.
const NOISY: f64 = 2.0;

/// A condition that an answer must meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Condition {
    /// The remaining error is small against noise or signal.
    Left,
    /// The repaired machine predicts no worse than the calibrated one, however far ahead.
    Horizons,
    /// No prediction is slightly worse than the calibrated machine's, and no free run strays although
    /// predictions of up to a second improve.
    Far,
    /// The remaining error depends on no known quantity, and no smooth force balances better instead of
    /// causes elsewhere.
    Residual,
    /// Every fitted value is plausible.
    Plausible,
    /// No believed value, nor the timing of commands, ends at the limit of its tolerance.
    Tolerance,
    /// No other place predicts the check experiments as well.
    Rivals,
    /// Every cause was tried and fitted to the end.
    Tried,
    /// The records do not contradict each other or the machine in units, signs or clocks.
    Records,
    /// The time sufficed for a table of the missing force, if no cause explains it.
    Table,
}

impl Condition {
    /// Whether a failure only leaves the answer in doubt, without evidence against it.
    fn is_of_others(self) -> bool {
        matches!(self, Self::Far | Self::Tolerance | Self::Rivals | Self::Tried | Self::Records | Self::Table)
    }
}

/// One reason why an answer is not called explained.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shortfall {
    /// The condition that is not met.
    pub condition: Condition,
    /// The finding in words.
    pub what: String,
}

/// The remaining error of an answer, in absolute terms, and the reasons why it is not called explained.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Adequacy {
    /// The limits that were applied.
    pub criteria: Criteria,
    /// Errors by horizon, the shortest first, the free run over whole records last.
    pub horizons: Vec<Horizon>,
    /// Root mean square of the drive's force on the check experiments, N (or N m).
    pub drive_force_n: f64,
    /// The quantities with which the force missing on the check experiments correlates.
    pub residual: Vec<ResidualTrace>,
    /// Reasons why the answer is not called explained; empty if all conditions hold.
    pub shortfalls: Vec<Shortfall>,
    /// Causes that may be hidden, and values that they may have moved, if calibration alone closes the gap.
    #[serde(skip)]
    pub(crate) doubts: Vec<Doubt>,
    /// Place of a smooth force that no cause makes, if that force improves the balance clearly.
    #[serde(skip)]
    pub(crate) smooth: Option<Place>,
    /// Whether that force balances better instead of the causes at other places.
    #[serde(skip)]
    pub(crate) is_replaced: bool,
    /// Whether the balance of forces leaves hardly any force missing.
    #[serde(skip)]
    pub(crate) is_balanced: bool,
    /// Whether the calibrated machine is nearly right and its residual depends on no known quantity.
    #[serde(skip)]
    pub(crate) is_noise: bool,
}

impl Adequacy {
    /// Whether a condition fails that is evidence against the answer itself.
    pub(crate) fn is_short(&self) -> bool {
        self.shortfalls.iter().any(|shortfall| !shortfall.condition.is_of_others())
    }

    /// Whether another explanation may be as good.
    pub(crate) fn has_rival(&self) -> bool {
        self.shortfalls.iter().any(|shortfall| shortfall.condition.is_of_others())
    }

    /// Whether the calibrated machine's errors are too small to name a cause for them.
    pub(crate) fn is_slight(&self) -> bool {
        horizons::are_slight(&self.horizons, &self.criteria)
    }

    fn fails(&self, condition: Condition) -> bool {
        self.shortfalls.iter().any(|shortfall| shortfall.condition == condition)
    }

    /// Whether calibration alone closes the gap, but a cause may be hidden.
    pub fn is_doubted(&self) -> bool {
        !self.doubts.is_empty()
    }

    /// Whether calibration alone closes the gap, but with a doubtful value.
    pub fn has_doubtful_value(&self) -> bool {
        self.doubts.iter().any(|doubt| doubt.about != Doubted::Cause)
    }

    /// Whether calibration alone closes the gap, but may hide a cause.
    pub fn may_hide_cause(&self) -> bool {
        self.doubts.iter().any(|doubt| doubt.about == Doubted::Cause)
    }

    /// Whether causes were left untried, or not fitted to the end, because the time ran out.
    pub fn has_untried(&self) -> bool {
        self.fails(Condition::Tried)
    }

    /// Whether a table of the missing force was left untried because the time ran out.
    pub fn has_untried_table(&self) -> bool {
        self.fails(Condition::Table)
    }

    /// Whether a column with a large residual in short predictions counts as unexplained. A balance of forces
    /// does not see the elongation of a joint, how two bodies of a chain move against each other. The stated
    /// or estimated noise may be too small.
    pub(crate) fn is_unexplained(&self, sigmas: f64, is_elongation: bool) -> bool {
        (!self.is_balanced || is_elongation) && (!self.is_noise || sigmas * sigmas > NOISY * ADEQUATE)
    }

    /// Adds the columns that short predictions do not explain, each with its residual in sigmas.
    pub(crate) fn add_unexplained(&mut self, columns: impl Iterator<Item = (String, f64)>) {
        let short = |(column, sigmas): (String, f64)| Shortfall {
            condition: Condition::Left,
            what: format!(
                "short predictions of {column} are off by {}, more than an imprecise law of friction or \
                 contact usually leaves",
                in_sigmas(sigmas)
            ),
        };
        self.shortfalls.extend(columns.map(short));
    }

    /// Adds a remaining error.
    pub(crate) fn add_left(&mut self, what: String) {
        self.shortfalls.push(Shortfall { condition: Condition::Left, what });
    }

    /// Adds causes that calibration may hide.
    pub(crate) fn add_hidden(&mut self, hidden: Vec<Doubt>) {
        self.add_rivals(hidden.iter().map(|doubt| doubt.what.clone()).collect());
        self.doubts.extend(hidden);
    }

    /// Removes the causes that calibration may hide.
    pub(crate) fn clear_hidden(&mut self) {
        let hidden: Vec<Doubt> = self.doubts.extract_if(.., |doubt| doubt.about == Doubted::Cause).collect();
        self.shortfalls.retain(|shortfall| hidden.iter().all(|doubt| doubt.what != shortfall.what));
    }

    /// Adds other causes that may be present.
    pub(crate) fn add_rivals(&mut self, rivals: Vec<String>) {
        let short = |what| Shortfall { condition: Condition::Rivals, what };
        self.shortfalls.extend(rivals.into_iter().map(short));
    }

    /// Whether all values of a machine are plausible. `has_causes` includes the values of its causes.
    /// Believed values at the limit of their tolerance are not plausible if another condition fails too.
    pub(crate) fn may_be_meant(&self, has_causes: bool) -> bool {
        let is_odd = has_causes && self.fails(Condition::Plausible);
        !(is_odd || self.is_short() && self.fails(Condition::Tolerance))
    }

    /// Adds the experiment over which the free run of an uncertain answer's machine is worse than the
    /// believed one's.
    pub(crate) fn add_stray(&mut self, experiment: &str, errors: [f64; 2]) {
        self.add_worse(experiment, errors, Condition::Far);
    }

    /// Adds that the free run of the repaired machine is worse than the believed one's.
    pub(crate) fn add_free_run(&mut self, errors: [f64; 2]) {
        // If the motion is unstable, every free run diverges from the records.
        let is_better = horizons::are_better(&self.horizons, &self.criteria);
        let condition = if is_better { Condition::Far } else { Condition::Horizons };
        self.add_worse("the check experiments", errors, condition);
    }

    fn add_worse(&mut self, over: &str, errors: [f64; 2], condition: Condition) {
        let [own, believed] = errors.map(horizons::share);
        let what = format!(
            "run freely over {over} the repaired machine is off by {own}, the believed one by \
             {believed}: the change is not proposed"
        );
        self.shortfalls.push(Shortfall { condition, what });
    }

    /// Adds that the time did not suffice to run the repaired machine freely.
    pub(crate) fn add_unrun(&mut self) {
        let what = "the time ran out before the repaired machine was run freely over the check experiments: \
                    the change is not proposed; a longer `--budget` runs it";
        self.shortfalls.push(Shortfall { condition: Condition::Tried, what: what.into() });
    }

    /// Reports that the time did not suffice for some causes, or to fit all to the end. Any of them may fit
    /// as well.
    pub(crate) fn add_untried(&mut self, untried: usize, is_unfinished: bool) {
        let what = match (untried, is_unfinished) {
            (0, false) => return,
            (0, true) => {
                "the time ran out before all causes were fitted to the end; a longer `--budget` finishes them"
                    .into()
            }
            _ => format!(
                "the time did not suffice for {untried} causes or sets; a longer `--budget` tries them"
            ),
        };
        self.shortfalls.push(Shortfall { condition: Condition::Tried, what });
    }

    /// Reports that the records contradict each other.
    pub(crate) fn add_contradiction(&mut self) {
        let what = "the records contradict each other, which may explain the findings".into();
        self.shortfalls.push(Shortfall { condition: Condition::Records, what });
    }

    /// Reports that the time did not suffice for a table of the missing force.
    pub(crate) fn add_untried_table(&mut self) {
        let what = "the time did not suffice for a table of the missing force, which can stand in for the \
                    cause; a longer `--budget` tries it"
            .into();
        self.shortfalls.push(Shortfall { condition: Condition::Table, what });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_two_sensors_of_a_joint_are_judged_even_if_all_forces_balance() {
        let of = |is_balanced, is_noise| Adequacy { is_balanced, is_noise, ..Adequacy::default() };
        let (large, small) = (2.0 * (NOISY * ADEQUATE).sqrt(), 0.9 * (NOISY * ADEQUATE).sqrt());
        for is_noise in [false, true] {
            assert!(of(true, is_noise).is_unexplained(large, true));
            assert!(!of(true, is_noise).is_unexplained(large, false));
            assert!(of(false, is_noise).is_unexplained(large, false));
            assert_eq!(of(true, is_noise).is_unexplained(small, true), !is_noise);
        }
    }

    #[test]
    fn truth_values_at_a_limit_or_beyond_reason_are_not_meant() {
        let of = |conditions: &[Condition]| {
            let short = |condition: &Condition| Shortfall { condition: *condition, what: String::new() };
            Adequacy { shortfalls: conditions.iter().map(short).collect(), ..Adequacy::default() }
        };
        // Calibration alone may be plausible if only a cause is implausible.
        let absurd = of(&[Condition::Plausible]);
        assert!(!absurd.may_be_meant(true) && absurd.may_be_meant(false));
        // A value at its limit hides another error if the residual has structure too. Alone it is only a
        // doubt.
        let limited = of(&[Condition::Tolerance]);
        assert!(limited.may_be_meant(true) && limited.may_be_meant(false));
        let unknown = of(&[Condition::Tolerance, Condition::Left]);
        assert!(!unknown.may_be_meant(true) && !unknown.may_be_meant(false));
    }
}
