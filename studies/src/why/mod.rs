//! Why a scenario chatters: counterfactual runs decide.
//!
//! The scenario is run again without one of its troubles at a time ([`Change`]); if none of these runs comes
//! to rest, without two, then three. The smallest set of changes after which the force settles is the cause.
//! Where several sets are as small, the verdict follows these rules, in order:
//!
//! A controller cannot be run in continuous time, only at a short period: where the force grows even then,
//! but by linear theory the less the shorter the period, down to none, a continuous controller counts as a
//! cure.
//!
//! Noise belongs to a sensor and an instant, so that all runs meet the same. What swings by it falls within
//! the settling band now and then: with noise, a change cures only where it leaves half the amplitude at
//! most, or no noise.
//!
//! 1. what vanishes with the step is a numerical artefact;
//! 2. what swings in contact, in a loop that linear theory does not call unstable, and rests without the
//!    sensors' noise is excited by that;
//! 3. where the sampled loop is stable in contact by linear theory, what keeps the motion going is what
//!    linear theory leaves out: dry friction or quantisation, then saturation, then the loss of contact, of
//!    those that cure;
//! 4. where it is unstable, the cause is the ingredient whose absence raises the largest stable gain most, of
//!    those that cure.

mod change;
mod linear;
mod remedy;
mod roles;
mod search;

use feeler_engine::Scenario;
use serde::Serialize;

pub use change::{Cause, Change};
pub use remedy::Remedy;
pub use search::Trial;

use crate::run::{Measured, Outcome, RunError, nothing_can_touch};

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
    /// What to do, cheapest in bandwidth first.
    pub remedies: Vec<Remedy>,
}

/// Explains a scenario. `progress` is told how many runs have been made.
///
/// # Errors
/// A scenario that cannot be run as it is.
pub fn explain(scenario: &Scenario, progress: &(dyn Fn(usize) + Sync)) -> Result<Explanation, RunError> {
    Ok(search::Search::new(scenario, progress)?.explain())
}

/// Whether a run of a scenario has come to rest, or is on its way there.
fn is_cured(scenario: &Scenario, measured: &Measured) -> bool {
    let verdict = &measured.summary.verdict;
    let rests_away = verdict.outcome == Outcome::NoContact && nothing_can_touch(scenario);
    rests_away
        || verdict.outcome.is_stable()
        || verdict.undecided == Some(crate::run::Undecided::StillDecaying)
}

/// Whether a run leaves something to explain.
fn is_troubled(measured: &Measured) -> bool {
    let verdict = &measured.summary.verdict;
    verdict.outcome.is_sustained()
        || verdict.outcome == Outcome::Unstable
        || verdict.undecided == Some(crate::run::Undecided::StillGrowing)
}
