//! What was found, and when a run counts as cured.

use feeler_engine::Scenario;
use serde::Serialize;

use super::change::{Cause, Change};
use super::size::Size;
use crate::run::{Measured, Outcome, Undecided, nothing_can_touch};

/// What was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// What becomes of the scenario as it is.
    pub baseline: Trial,
    /// Whether there is anything to explain: the force does not come to rest.
    pub chatters: bool,
    /// Largest factor on the loop's gain up to which the sampled loop is stable in contact; infinite values
    /// and failures of linear theory are absent.
    pub gain_margin: Option<f64>,
    /// Whether linear theory calls the loop stable in contact.
    pub linear_stable: Option<bool>,
    /// Whether the force is fed back with the wrong sign: the loop in contact pushes itself away without
    /// swinging, and reversed it would not.
    pub wrong_sign: bool,
    /// Whether a mode of the machine in contact has no damping.
    pub undamped: bool,
    /// Each change by itself.
    pub singles: Vec<Trial>,
    /// Every smallest set of changes that removes the chatter, the chosen one first.
    pub smallest: Vec<Vec<Change>>,
    /// What becomes of the scenario without the chosen set, and with each member of it left out: what each
    /// contributes.
    pub contributions: Vec<Trial>,
    /// The causes, in order of weight; two or more act together.
    pub causes: Vec<Cause>,
    /// The verdict in one sentence.
    pub verdict: String,
    /// What lifts the largest stable gain most, where that is by much and it is not what was chosen.
    pub lift: Option<Lift>,
    /// How large a change has to be after which the force settles, of those that have a size.
    pub sizes: Vec<Size>,
    /// What to do, cheapest in bandwidth first.
    pub remedies: Vec<Remedy>,
}

/// A change that lifts the largest stable gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lift {
    /// The change.
    pub change: Change,
    /// Largest factor on the loop's gain as it is.
    pub from: f64,
    /// The same with the change; `None` if no change within reason destabilises the loop.
    pub to: Option<f64>,
}

/// A run with some changes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// What was changed.
    pub changes: Vec<Change>,
    /// Whether the scenario has what the changes take away; where not, they were not run, and the figures are
    /// those of the scenario as it is.
    pub applies: bool,
    /// What became of it; absent if it could not be run.
    pub outcome: Option<Outcome>,
    /// Whether the force comes to rest.
    pub cured: bool,
    /// Whether it counts as cured though it grows, since by linear theory it grows only by the period, short
    /// as that is, of a controller that stands for a continuous one.
    pub only_by_period: bool,
    /// Amplitude of what lasts, N.
    pub amplitude_n: Option<f64>,
    /// Its frequency, Hz.
    pub frequency_hz: Option<f64>,
    /// Largest factor on the loop's gain up to which the sampled loop is stable in contact; absent if
    /// unbounded or unknown.
    pub gain_margin: Option<f64>,
    /// Why it could not be run.
    pub error: Option<String>,
}

/// A way out, checked by simulation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Remedy {
    /// What to do.
    pub what: String,
    /// What `--set` takes to do it, gain included; `feeler why FILE --try N --out FILE` writes it.
    pub settings: Vec<String>,
    /// Factor on the loop's gain that goes with it: 1 where the gain can stay.
    pub gain_factor: f64,
    /// Frequency up to which the force then follows its reference, to 3 dB, Hz; absent if linear theory
    /// has no answer.
    pub bandwidth_hz: Option<f64>,
    /// What that costs, as a share of the bandwidth of the loop as it is; below zero where something is
    /// gained.
    pub cost: Option<f64>,
    /// Whether the force then settles in simulation.
    pub settles: bool,
}

/// Whether a run of a scenario has come to rest, or is on its way there.
pub(super) fn is_cured(scenario: &Scenario, measured: &Measured) -> bool {
    let verdict = &measured.summary.verdict;
    let rests_away = verdict.outcome == Outcome::NoContact && nothing_can_touch(scenario);
    rests_away || verdict.outcome.is_stable() || verdict.undecided == Some(Undecided::StillDecaying)
}

/// Whether a run leaves something to explain.
pub(super) fn is_troubled(measured: &Measured) -> bool {
    let verdict = &measured.summary.verdict;
    verdict.outcome.is_sustained()
        || verdict.outcome == Outcome::Unstable
        || verdict.undecided == Some(Undecided::StillGrowing)
}
