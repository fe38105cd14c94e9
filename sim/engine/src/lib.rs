//! Stepping a machine through time.

mod scenario;

pub use scenario::{ControllerUse, Integrator, RunSettings, Scenario};
