//! What is measured or drawn of a loop.

pub(crate) mod curves;
pub mod frf;
