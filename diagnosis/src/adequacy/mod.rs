//! Conditions that an answer must meet to be called explained, judged apart from the ranking that found it.
//!
//! A ranking says which cause is the best of those tried. This module says whether the best is good enough.
//! It asks what is left at every horizon, and whether that still depends on anything. It also asks whether
//! every value is plausible, and whether another place would do as well.

mod balance;
mod criteria;
mod held;
mod horizons;
mod plausible;
mod residual;
mod rivals;
mod tolerance;

pub(crate) use balance::{as_good, further};
pub use criteria::Criteria;
pub use horizons::Horizon;
pub use residual::Trace;

use feeler_plant::effects::Place;
use serde::Serialize;

use crate::diagnose::Judge;
use crate::fit::scored::Scored;

/// Which condition an answer does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Condition {
    /// What is left is small against noise or signal.
    Left,
    /// The repaired machine predicts no worse than the calibrated one, however far ahead.
    Horizons,
    /// The remaining error depends on nothing that could explain it.
    Residual,
    /// Every fitted value can be meant.
    Plausible,
    /// No believed value ends at the limit of its tolerance.
    Tolerance,
    /// No other place predicts the check experiments as well.
    Rivals,
    /// Every cause was tried.
    Tried,
}

impl Condition {
    /// Whether it is about what else there may be, and not about the answer itself.
    fn is_of_others(self) -> bool {
        matches!(self, Self::Tolerance | Self::Rivals | Self::Tried)
    }
}

/// One reason why an answer is not called explained.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shortfall {
    /// The condition.
    pub condition: Condition,
    /// What was found, in words.
    pub what: String,
}

/// What an answer leaves, in absolute terms, and what keeps it from being called explained.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Adequacy {
    /// What it was held against.
    pub criteria: Criteria,
    /// Errors by how far ahead predictions reach, the shortest first, the free run of whole records last.
    pub horizons: Vec<Horizon>,
    /// Root mean square of the drive's force on the check experiments, N (or N m).
    pub drive_force_n: f64,
    /// The quantities on which the force depends that is still missing on the check experiments.
    pub residual: Vec<Trace>,
    /// Why the answer is not better; empty where all conditions hold.
    pub shortfalls: Vec<Shortfall>,
    /// Where a smooth force that no cause makes acts, if one would balance clearly more.
    #[serde(skip)]
    pub(crate) smooth: Option<Place>,
    /// Whether a balance of forces leaves next to nothing.
    #[serde(skip)]
    pub(crate) is_balanced: bool,
}

impl Adequacy {
    /// Whether anything of its own keeps the answer from being called explained.
    pub(crate) fn is_short(&self) -> bool {
        self.shortfalls.iter().any(|shortfall| !shortfall.condition.is_of_others())
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
    pub(crate) fn add_unexplained<'a>(&mut self, columns: impl Iterator<Item = (&'a str, f64)>) {
        let short = |(column, sigmas): (&str, f64)| Shortfall {
            condition: Condition::Left,
            what: format!(
                "short predictions of `{column}` are off by {sigmas:.1} sigma, more than an imprecise law of \
                 friction or contact usually leaves"
            ),
        };
        self.shortfalls.extend(columns.map(short));
    }

    /// Tells what else may be there.
    pub(crate) fn add_further(&mut self, further: Vec<String>) {
        let short = |what| Shortfall { condition: Condition::Rivals, what };
        self.shortfalls.extend(further.into_iter().map(short));
    }

    /// Tells that the repaired machine runs freely farther off than the believed one, where it does.
    pub(crate) fn add_free_run(&mut self, worse: Option<[f64; 2]>) {
        let Some([own, believed]) = worse else { return };
        let [own, believed] = [own, believed].map(horizons::share);
        let what = format!(
            "run freely over the check experiments the repaired machine is off by {own}, the believed one by \
             {believed}: the change is not proposed"
        );
        self.shortfalls.push(Shortfall { condition: Condition::Horizons, what });
    }

    /// Tells that the time did not suffice for some causes, any of which may do as well.
    pub(crate) fn add_untried(&mut self, causes: usize) {
        if causes > 0 {
            let what = format!(
                "the time did not suffice for {causes} causes or sets; a longer `--budget` tries them"
            );
            self.shortfalls.push(Shortfall { condition: Condition::Tried, what });
        }
    }
}

/// What of an answer's size the conditions need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes {
    /// What noise alone leaves of short predictions, over each channel's variation.
    pub(crate) floor: f64,
    /// Share of the error beyond it that the accepted causes remove; `None` if they leave little more than
    /// the floor.
    pub(crate) closed: Option<f64>,
    /// Force missing on the check experiments after calibration and with what was accepted, beyond what noise
    /// makes, N.
    pub(crate) missing_force_n: [f64; 2],
}

/// Holds an answer against all conditions. `rivals` are the causes that were weighed against the accepted
/// ones, `balanced` those that balance the forces as well.
pub(crate) fn assess(
    judge: &Judge<'_>,
    accepted: &Scored,
    rivals: &[Scored],
    balanced: &[&Scored],
    sizes: Sizes,
) -> Adequacy {
    let criteria = Criteria::default();
    let task = &judge.search.task;
    let calibrated = &judge.search.calibrated;
    let checks = judge.checks();
    let horizons = horizons::of(task, calibrated, accepted, &checks, sizes.floor);
    let residual = residual::of(task, accepted, &checks, &criteria);
    let mut shortfalls = Vec::new();
    let mut short = |condition: Condition, found: Vec<String>| {
        shortfalls.extend(found.into_iter().map(|what| Shortfall { condition, what }));
    };
    let missing = sizes.missing_force_n;
    let is_found = !accepted.causes.is_empty();
    // A balance, where it weighs, leaves the noise of the command out.
    let shares = balance::missing(judge, accepted);
    let is_balanced = balance::is_small(shares, &criteria);
    let missing = shares.map_or(missing, |shares| shares.map(|share| share * residual.drive_force_n));
    short(
        Condition::Left,
        horizons::left(&horizons, missing, residual.drive_force_n, [is_found, is_balanced], &criteria),
    );
    if task.dataset.machine.contacts.is_empty() {
        short(Condition::Left, horizons::lost(&horizons, &criteria).into_iter().collect());
    }
    if is_found && !is_balanced {
        let unclosed = sizes.closed.and_then(|closed| horizons::unclosed(closed, &criteria));
        short(Condition::Left, unclosed.into_iter().collect());
    }
    short(Condition::Residual, residual.shortfalls(missing[0], &criteria));
    let smooth = balance::beyond(judge, accepted, &criteria);
    short(Condition::Residual, smooth.map(balance::told).into_iter().collect());
    short(Condition::Rivals, balance::named(balanced));
    short(Condition::Tolerance, tolerance::limits(accepted));
    if is_found {
        short(Condition::Horizons, horizons::worsened(&horizons, &criteria));
        let free_run = horizons.iter().find(|horizon| horizon.seconds.is_none());
        let strayed = held::strayed(task.dataset, free_run.and_then(|horizon| horizon.after));
        short(Condition::Horizons, strayed.into_iter().collect());
        short(Condition::Plausible, plausible::doubts(judge, accepted, &criteria));
        short(Condition::Rivals, rivals::as_good(judge, accepted, rivals, &horizons, &criteria));
    }
    Adequacy {
        criteria,
        horizons,
        drive_force_n: residual.drive_force_n,
        residual: residual.traces,
        shortfalls,
        smooth: smooth.map(|smooth| smooth.place),
        is_balanced,
    }
}
