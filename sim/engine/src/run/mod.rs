//! A scenario, its program, and the run from instant to instant.

mod building;
pub(crate) mod program;
mod recorder;
pub(crate) mod scenario;
pub(crate) mod servo;
pub(crate) mod settings;
pub(crate) mod simulation;
pub(crate) mod wanted;
mod wiring;
