//! The interface through which another engine moves the bodies.

use std::fmt::Debug;

use crate::error::EngineError;

/// Another engine that integrates the bodies of one machine.
///
/// All other parts of a run stay the same. These are controllers, drive chains, sensors and their filters,
/// the laws of contacts, links and friction, instants and events. At the start of each step the forces of all
/// elements are evaluated at the present state. The engine then moves the bodies over the step under these
/// constant forces.
pub trait BodyEngine: Debug + Send {
    /// Moves the bodies by `step_s` under `forces_n`, one per coordinate (see
    /// [`feeler_plant::motion::Coordinates`]), and writes the result to `positions_m` and `speeds_m_per_s`.
    /// On entry these hold the present values: those that the engine wrote, except for changes by a stop, a
    /// stick or a caller since. A state that is not finite ends the run as diverged.
    ///
    /// # Errors
    /// [`EngineError::Problems`] for a motion that this engine cannot follow in steps of this length.
    fn step(
        &mut self,
        step_s: f64,
        forces_n: &[f64],
        positions_m: &mut [f64],
        speeds_m_per_s: &mut [f64],
    ) -> Result<(), EngineError>;
}
