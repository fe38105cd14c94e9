//! Why a scenario chatters: counterfactual runs decide.
//!
//! The scenario is run again without one of its nonideal properties at a time ([`Counterfactual`]). If none
//! of these runs comes to rest, two are removed, then three. The smallest set of changes after which the
//! force settles is the cause.
//!
//! A controller cannot be run in continuous time, only at a short period. The force may still grow then. If
//! by linear theory its growth vanishes with the period, a continuous controller counts as a cure.
//!
//! Noise depends on sensor and instant only, so all runs have the same noise. An oscillation by noise
//! sometimes falls within the settling band. With noise, a change therefore cures only if it leaves at most
//! half the amplitude, or removes the noise.
//!
//! If several sets have the same size, the verdict follows these rules, in order:
//!
//! 1. a motion that vanishes with the step is a numerical artefact;
//! 2. a motion in contact is excited by the sensors' noise if it rests without noise and linear theory does
//!    not call the loop unstable;
//! 3. if the sampled loop is stable in contact by linear theory, a nonlinear property sustains the motion. Of
//!    those that cure, dry friction, quantisation or free play comes first, then saturation, then the loss of
//!    contact;
//! 4. if it is unstable, the cause is the ingredient whose absence raises the largest stable gain most, of
//!    those that cure.

mod applied;
mod change;
mod explanation;
mod linear;
mod remedy;
mod roles;
mod search;
mod size;
mod words;

use feeler_engine::Scenario;

pub use change::{ChatterCause, Counterfactual};
pub use explanation::{CheckedRemedy, Explanation, Lift, Size, Trial};
pub(crate) use linear::scale_errors;

use crate::run::RunError;

/// Explains a scenario. `progress` receives the number of completed runs.
///
/// # Errors
/// A scenario that cannot be run unchanged.
pub fn explain(scenario: &Scenario, progress: &(dyn Fn(usize) + Sync)) -> Result<Explanation, RunError> {
    Ok(search::WhySearch::new(scenario, progress)?.explain())
}
