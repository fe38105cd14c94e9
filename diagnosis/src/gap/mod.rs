//! How large the gap between model and records is, where it shows, and what is left of it.

pub(crate) mod ladder;
pub(crate) mod locate;
pub mod replay;
pub(crate) mod size;
pub(crate) mod unknown;
