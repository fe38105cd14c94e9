//! Rapier as a second engine.
//!
//! A machine's coordinates become rigid bodies in space, each on a joint to the ground that leaves only the
//! axis of motion free. The joint is prismatic along x, or revolute about x for a rotational axis.
//! [`RapierBodies`] moves them. Controllers, drive chains, sensors, effects and the laws of contacts, links
//! and friction are those of `feeler-engine` and `feeler-plant`. They are evaluated at Rapier's positions and
//! velocities and passed to it as external forces.
//!
//! Rapier integrates by semi-implicit Euler, so a run converges to the exact one at first order in the step.

mod bodies;

pub use bodies::{LARGEST_TURN, RapierBodies};
