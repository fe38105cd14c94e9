//! Linear models of a machine: view, operating point, state space and modes.

pub(crate) mod assumptions;
pub(crate) mod channel;
pub(crate) mod equilibrium;
mod from_drive;
pub(crate) mod imposed;
pub(crate) mod linearise;
pub(crate) mod modes;
pub(crate) mod outer_force;
pub(crate) mod prepare;
