//! A scenario, the program made of it, and its run from instant to instant.

mod building;
pub(crate) mod instants;
pub(crate) mod program;
pub(crate) mod scenario;
pub(crate) mod simulation;
pub(crate) mod standing;
mod wiring;
