//! The record of a run, and how records are kept and written.

pub(crate) mod event;
pub(crate) mod lanes;
pub(crate) mod recording;
pub(crate) mod trace_file;
