//! A machine as linear theory sees it: what is kept, where it rests, its state space and its modes.

pub(crate) mod assumptions;
pub(crate) mod channel;
pub(crate) mod equilibrium;
pub(crate) mod linearise;
pub(crate) mod modes;
pub(crate) mod outer_force;
pub(crate) mod prepare;
