//! Stepping a machine through time.
//!
//! A [`Scenario`] is what is to be run; [`Program`] is the same checked and resolved; [`Simulation`] runs one
//! variant of it, or several side by side. Between events a machine is linear with held inputs, so the
//! default integrator carries it by matrix exponentials and locates every event in between to rounding; modes
//! with laws that are not linear are integrated by extrapolation to the same accuracy (see
//! [`Integrator::Exact`]).

mod bodies;
mod clock;
mod control_loop;
mod crossing;
mod drive;
mod error;
mod event;
mod exponentials;
mod extrapolation;
mod fixed_step;
mod flow;
mod formation;
mod instants;
mod lane;
mod ledger;
mod observer;
mod peaks;
mod program;
mod scenario;
mod sensing;
mod simulation;
mod standing;
mod step_map;
mod taps;
mod taylor;
mod transition;
mod travel;

/// Sampling parts of the engine for simulators with motions of their own, so that drives and sensors are the
/// same everywhere.
pub mod parts {
    pub use crate::clock::{SAME_INSTANT_S, due};
    pub use crate::drive::DriveChain;
    pub use crate::sensing::Sensing;
    pub use crate::taps::Tap;
}

pub use bodies::BodyEngine;
pub use error::{EngineError, RunEnd};
pub use event::{Event, EventKind};
pub use exponentials::sharing_exponentials;
pub use ledger::EnergyBalance;
pub use observer::{Observer, Trace, Unobserved};
pub use peaks::Peak;
pub use program::{LoopWiring, Program};
pub use scenario::{ControllerUse, Integrator, RunSettings, Scenario};
pub use simulation::Simulation;
