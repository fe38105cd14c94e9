//! Measured responses and drawn curves of a loop.

pub(crate) mod curves;
pub mod frf;
