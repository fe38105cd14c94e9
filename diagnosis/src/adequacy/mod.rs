//! Conditions that an answer must meet to be called explained, judged apart from the ranking that found it.
//!
//! A ranking says which cause is the best of those tried. This module says whether the best is good enough.
//! It measures the error at every horizon, and tests whether it still depends on anything. It also asks
//! whether every value is plausible, and whether another place would do as well.

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

use feeler_plant::effects::Place;
use serde::Serialize;

/// Which condition an answer does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Condition {
    /// The remaining error is small against noise or signal.
    Left,
    /// The repaired machine predicts no worse than the calibrated one, however far ahead.
    Horizons,
    /// Far ahead nothing became slightly worse, and no free run strays whose predictions became better.
    Far,
    /// The remaining error depends on nothing that could explain it.
    Residual,
    /// Every fitted value can be meant.
    Plausible,
    /// No believed value ends at the limit of its tolerance, nor the timing of commands.
    Tolerance,
    /// No other place predicts the check experiments as well.
    Rivals,
    /// Every cause was tried.
    Tried,
}

impl Condition {
    /// Whether it leaves the answer in doubt, and does not speak against it.
    fn is_of_others(self) -> bool {
        matches!(self, Self::Far | Self::Tolerance | Self::Rivals | Self::Tried)
    }
}

/// One reason why an answer is not called explained.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shortfall {
    /// Which condition is not met.
    pub condition: Condition,
    /// The finding in words.
    pub what: String,
}

/// The remaining error of an answer, in absolute terms, and the reasons why it is not called explained.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Adequacy {
    /// The limits that were applied.
    pub criteria: Criteria,
    /// Errors by how far ahead predictions reach, the shortest first, the free run of whole records last.
    pub horizons: Vec<Horizon>,
    /// Root mean square of the drive's force on the check experiments, N (or N m).
    pub drive_force_n: f64,
    /// The quantities on which the force depends that is still missing on the check experiments.
    pub residual: Vec<ResidualTrace>,
    /// Why the answer is not better; empty where all conditions hold.
    pub shortfalls: Vec<Shortfall>,
    /// Place of a smooth force that no cause makes, if one would balance clearly more.
    #[serde(skip)]
    pub(crate) smooth: Option<Place>,
    /// Whether a balance of forces leaves next to nothing.
    #[serde(skip)]
    pub(crate) is_balanced: bool,
    /// Whether a calibrated machine is nearly right, and its residual depends on nothing.
    #[serde(skip)]
    pub(crate) is_noise: bool,
}

impl Adequacy {
    /// Whether anything of its own keeps the answer from being called explained.
    pub(crate) fn is_short(&self) -> bool {
        self.shortfalls.iter().any(|shortfall| !shortfall.condition.is_of_others())
    }

    /// Whether the residual has structure, or predictions became worse farther ahead.
    pub(crate) fn is_structured(&self) -> bool {
        let is_of_model =
            |short: &Shortfall| matches!(short.condition, Condition::Residual | Condition::Horizons);
        self.shortfalls.iter().any(is_of_model)
    }

    /// Whether something else may do as well.
    pub(crate) fn has_rival(&self) -> bool {
        self.shortfalls.iter().any(|shortfall| shortfall.condition.is_of_others())
    }

    /// Whether the calibrated machine predicts so well that no cause of the rest is worth a name.
    pub(crate) fn is_slight(&self) -> bool {
        horizons::are_slight(&self.horizons, &self.criteria)
    }

    /// Whether causes were left untried because the time ran out.
    pub fn has_untried(&self) -> bool {
        self.shortfalls.iter().any(|shortfall| shortfall.condition == Condition::Tried)
    }

    /// Tells which columns short predictions do not explain, each with its residual in sigmas.
    pub(crate) fn add_unexplained(&mut self, columns: impl Iterator<Item = (String, f64)>) {
        let short = |(column, sigmas): (String, f64)| Shortfall {
            condition: Condition::Left,
            what: format!(
                "short predictions of {column} are off by {sigmas:.1} sigma, more than an imprecise law of \
                 friction or contact usually leaves"
            ),
        };
        self.shortfalls.extend(columns.map(short));
    }

    /// Tells what else may be there.
    pub(crate) fn add_rivals(&mut self, rivals: Vec<String>) {
        let short = |what| Shortfall { condition: Condition::Rivals, what };
        self.shortfalls.extend(rivals.into_iter().map(short));
    }

    /// Whether all values of a machine may be meant. Those of the causes count if it has them. So do believed
    /// values at the limit of their tolerance, if something else is wrong too.
    pub(crate) fn may_be_meant(&self, has_causes: bool) -> bool {
        let fails =
            |condition| self.shortfalls.iter().any(|shortfall: &Shortfall| shortfall.condition == condition);
        let is_odd = has_causes && fails(Condition::Plausible);
        !(is_odd || self.is_short() && fails(Condition::Tolerance))
    }

    /// Tells over which experiment the machine of an answer that is not sure runs farther off than the
    /// believed one.
    pub(crate) fn add_stray(&mut self, experiment: &str, errors: [f64; 2]) {
        self.add_worse(experiment, errors, Condition::Far);
    }

    /// Tells that the repaired machine runs freely farther off than the believed one.
    pub(crate) fn add_free_run(&mut self, errors: [f64; 2]) {
        // A motion that falls or runs away makes any free run leave the records.
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

    /// Reports that the time did not suffice for some causes, any of which may do as well.
    pub(crate) fn add_untried(&mut self, causes: usize) {
        if causes > 0 {
            let what = format!(
                "the time did not suffice for {causes} causes or sets; a longer `--budget` tries them"
            );
            self.shortfalls.push(Shortfall { condition: Condition::Tried, what });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_values_at_a_limit_or_beyond_reason_are_not_meant() {
        let of = |conditions: &[Condition]| {
            let short = |condition: &Condition| Shortfall { condition: *condition, what: String::new() };
            Adequacy { shortfalls: conditions.iter().map(short).collect(), ..Adequacy::default() }
        };
        // Calibration alone may be meant where only a cause is beyond reason.
        let absurd = of(&[Condition::Plausible]);
        assert!(!absurd.may_be_meant(true) && absurd.may_be_meant(false));
        // A limit beside what nothing explains hides something else; alone it is a doubt.
        let limited = of(&[Condition::Tolerance]);
        assert!(limited.may_be_meant(true) && limited.may_be_meant(false));
        let unknown = of(&[Condition::Tolerance, Condition::Left]);
        assert!(!unknown.may_be_meant(true) && !unknown.may_be_meant(false));
    }
}
