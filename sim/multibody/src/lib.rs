//! Rapier as a second engine.
//!
//! A machine's coordinates become rigid bodies in space, each on a joint to the ground that leaves it the
//! axis of motion: a prismatic joint along x, or a revolute joint about x where the axis is rotational.
//! [`RapierBodies`] moves them; controllers, drive chains, sensors, effects and the laws of contacts, links
//! and friction are the ones of `feeler-engine` and `feeler-plant`, evaluated at Rapier's positions and
//! velocities and handed to it as external forces.
//!
//! Rapier integrates by semi-implicit Euler, so a run converges to the exact one at first order in the step.

mod bodies;

pub use bodies::{LARGEST_TURN, RapierBodies};
