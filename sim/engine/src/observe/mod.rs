//! Events of a run, and its observers.

pub(crate) mod event;
pub(crate) mod observer;
