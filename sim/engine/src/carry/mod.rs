//! The motion between two instants: lanes side by side, each through its own events.

mod abreast;
pub(crate) mod bodies;
pub(crate) mod carrier;
mod fixed_step;
mod formation;
mod lane;
pub(crate) mod lanes;
pub(crate) mod ledger;
pub(crate) mod peaks;
mod signals;
mod step_map;
mod toil;
mod transition;
