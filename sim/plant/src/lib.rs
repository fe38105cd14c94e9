//! The machine: what the user wrote ([`description`]), names resolved and effects applied ([`assembly`]).

pub mod assembly;
pub mod description;
pub mod effects;
pub mod names;
pub mod problem;
pub mod units;
