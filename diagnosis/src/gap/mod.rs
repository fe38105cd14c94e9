//! The gap between model and records: its size, its location, and the remaining part.

pub(crate) mod ladder;
pub(crate) mod locate;
pub mod replay;
pub(crate) mod size;
pub(crate) mod unknown;
