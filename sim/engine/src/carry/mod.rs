//! The motion between two instants: lanes side by side, and each through events of its own.

pub(crate) mod bodies;
pub(crate) mod fixed_step;
pub(crate) mod formation;
pub(crate) mod lane;
pub(crate) mod ledger;
pub(crate) mod peaks;
pub(crate) mod step_map;
pub(crate) mod transition;
pub(crate) mod travel;
