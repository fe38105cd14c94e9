//! A machine with its controllers: sampled, continuous, opened and closed.

pub(crate) mod closed_loop;
pub(crate) mod continuous_law;
pub(crate) mod continuous_loop;
pub(crate) mod control_loop;
pub(crate) mod gain_key;
pub(crate) mod late;
pub(crate) mod loop_pair;
pub(crate) mod sampled_loop;
pub(crate) mod schedule;
mod spans;
pub(crate) mod step_response;
