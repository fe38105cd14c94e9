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
mod explanation;
mod linear;
mod remedy;
mod roles;
mod search;
mod size;

use feeler_engine::Scenario;

pub use change::{Cause, Change};
pub use explanation::{Explanation, Lift, Remedy, Trial};
pub(crate) use remedy::scale_errors;
pub use size::Size;

use crate::run::RunError;

/// Explains a scenario. `progress` is told how many runs have been made.
///
/// # Errors
/// A scenario that cannot be run as it is.
pub fn explain(scenario: &Scenario, progress: &(dyn Fn(usize) + Sync)) -> Result<Explanation, RunError> {
    Ok(search::Search::new(scenario, progress)?.explain())
}
