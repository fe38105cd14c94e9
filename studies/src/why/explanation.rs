//! The findings, and when a run counts as cured.

use feeler_engine::Scenario;
use serde::Serialize;

use super::change::{ChatterCause, Counterfactual};
use crate::run::{Measured, Outcome, Undecided, nothing_can_touch};

/// Largest number of changes that are tried together.
pub(super) const LARGEST_SET: usize = 3;

/// The findings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// Outcome of the unchanged scenario.
    pub baseline: Trial,
    /// Whether there is something to explain: the force does not come to rest.
    pub chatters: bool,
    /// Largest factor on the loop's gain up to which the sampled loop is stable in contact; `None` if
    /// infinite or if linear theory fails.
    pub gain_margin: Option<f64>,
    /// Whether the loop is stable in contact by linear theory; `None` if linear theory fails.
    pub linear_stable: Option<bool>,
    /// Whether the force feedback has the wrong sign: the loop in contact pushes itself away without
    /// oscillation, and with reversed sign it would not.
    pub wrong_sign: bool,
    /// Whether a mode of the machine in contact has no damping.
    pub undamped: bool,
    /// Each change by itself.
    pub singles: Vec<Trial>,
    /// Every smallest set of changes that removes the chatter, the chosen one first.
    pub smallest: Vec<Vec<Counterfactual>>,
    /// Outcomes without the chosen set, and with each of its members omitted: the contribution of each.
    pub contributions: Vec<Trial>,
    /// The causes, in order of weight; two or more act together.
    pub causes: Vec<ChatterCause>,
    /// The verdict in one sentence.
    pub verdict: String,
    /// The change that raises the largest stable gain most, if by much and not the chosen one.
    pub lift: Option<Lift>,
    /// Without chatter: the changes that raise the largest stable gain, the largest first.
    pub lifts: Vec<Lift>,
    /// Smallest sizes of changes after which the force settles, if these have a size.
    pub sizes: Vec<Size>,
    /// Remedies, largest bandwidth first.
    pub remedies: Vec<CheckedRemedy>,
}

/// A change that raises the largest stable gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lift {
    /// The change: one property made ideal.
    pub change: Counterfactual,
    /// Largest factor on the loop's gain without the change.
    pub from: f64,
    /// Largest factor with the change; `None` if no reasonable gain destabilises the loop.
    pub to: Option<f64>,
}

/// A run with some changes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// The changes.
    pub changes: Vec<Counterfactual>,
    /// Whether the scenario has the property that the changes remove; if not, they were not run, and the
    /// figures are those of the unchanged scenario.
    pub applies: bool,
    /// Its outcome; `None` if it could not be run.
    pub outcome: Option<Outcome>,
    /// Whether the force comes to rest.
    pub cured: bool,
    /// Whether it counts as cured although it grows. By linear theory it grows only by the short period of a
    /// controller that represents a continuous one.
    pub only_by_period: bool,
    /// Amplitude of the oscillation that lasts, N; `None` if none does. It has the unit of `controlled` if
    /// that is present.
    pub amplitude_n: Option<f64>,
    /// The motion that decided the outcome; absent if a force did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controlled: Option<String>,
    /// Its frequency, Hz; `None` without an oscillation.
    pub frequency_hz: Option<f64>,
    /// Largest factor on the loop's gain up to which the sampled loop is stable in contact; `None` if
    /// unbounded or unknown.
    pub gain_margin: Option<f64>,
    /// Why it could not be run; `None` if it could.
    pub error: Option<String>,
}

/// A remedy, checked by simulation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckedRemedy {
    /// The remedy in words.
    pub what: String,
    /// The `--set` arguments of the remedy, including the gain; `feeler why FILE --try N --out FILE` writes
    /// it.
    pub settings: Vec<String>,
    /// The accompanying factor on the loop's gain: 1 if the gain can stay.
    pub gain_factor: f64,
    /// Frequency up to which the force then follows its reference, to 3 dB, Hz; `None` if linear theory has
    /// no answer.
    pub bandwidth_hz: Option<f64>,
    /// Its cost as a share of the present bandwidth; negative for a gain in bandwidth, `None` without a
    /// bandwidth to compare.
    pub cost: Option<f64>,
    /// Whether the force then settles in simulation, within the run of the file with its settings.
    pub settles: bool,
}

/// State in which a verdict's loop is closed: in contact, if anything can touch.
pub(super) fn in_contact(scenario: &Scenario) -> &'static str {
    if nothing_can_touch(scenario) { "" } else { " in contact" }
}

/// A change of sufficient size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Size {
    /// The change.
    pub of: Counterfactual,
    /// The required change, in words with its numbers.
    pub what: String,
    /// Factor by which its quantity is smaller or larger than in the scenario.
    pub times: f64,
    /// The `--set` arguments that apply it.
    pub settings: Vec<String>,
}

/// Whether a run of a scenario has come to rest.
pub(super) fn is_at_rest(scenario: &Scenario, measured: &Measured) -> bool {
    let outcome = measured.summary.outcome;
    outcome.is_stable() || (outcome == Outcome::NoContact && nothing_can_touch(scenario))
}

/// Whether a run of a scenario has come to rest, or is about to.
pub(super) fn is_cured(scenario: &Scenario, measured: &Measured) -> bool {
    is_at_rest(scenario, measured) || measured.summary.verdict.undecided == Some(Undecided::StillDecaying)
}

/// Whether a run has something to explain.
pub(super) fn is_troubled(measured: &Measured) -> bool {
    let verdict = &measured.summary.verdict;
    verdict.outcome.is_sustained()
        || verdict.outcome == Outcome::Unstable
        || verdict.undecided == Some(Undecided::StillGrowing)
}
