//! Steps a machine through time.
//!
//! A [`Scenario`] describes a run. A [`Program`] is a scenario that is checked and resolved. A [`Simulation`]
//! runs one variant of it, or several side by side. Between events a machine with held inputs is linear. The
//! default integrator moves it by matrix exponentials and locates every event to machine precision. Modes
//! with nonlinear laws are integrated by extrapolation to the same accuracy (see [`Integrator::Exact`]).

mod carry;
mod error;
mod observe;
mod run;
mod sample;
mod solve;

/// Sampling parts of the engine for simulators with their own motion, so that drives and sensors are the same
/// everywhere.
pub mod parts {
    pub use crate::run::wanted::Tapped;
    pub use crate::sample::clock::{SAME_INSTANT_S, due};
    pub use crate::sample::drive::DriveChain;
    pub use crate::sample::sampler::{Sampled, Sampler};
    pub use crate::sample::sensing::Sensing;
    pub use crate::sample::servo_loop::follow;
    pub use crate::sample::taps::Tap;
}

pub use carry::bodies::BodyEngine;
pub use carry::ledger::EnergyBalance;
pub use carry::peaks::Peak;
pub use error::{EngineError, RunEnd};
pub use observe::event::{Event, EventKind};
pub use observe::observer::{Observer, Trace, Unobserved};
pub use run::program::{LoopWiring, Program};
pub use run::scenario::{ControllerUse, Scenario};
pub use run::servo::{knots, servo_spec};
pub use run::settings::{Integrator, RunSettings};
pub use run::simulation::{Simulation, Stop};
pub use solve::exponentials::sharing_exponentials;
