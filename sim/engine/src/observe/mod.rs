//! Events of a run, and who watches it.

pub(crate) mod event;
pub(crate) mod observer;
