//! The seam at which another engine can move the bodies.

use std::fmt::Debug;

use crate::error::EngineError;

/// Another engine's integration of the bodies of one machine.
///
/// Everything else of a run stays what it is: controllers, drive chains, sensors and their filters, the laws
/// of contacts, links and friction, instants and events. At the start of each step the forces of all elements
/// are evaluated at the present state, and the engine carries the bodies over the step under these held
/// forces.
pub trait BodyEngine: Debug + Send {
    /// Moves the bodies by `step_s` under `forces_n`, one per coordinate (see
    /// [`feeler_plant::motion::Coordinates`]), and leaves in `positions_m` and `speeds_m_per_s` where they
    /// have come. What these hold before the step is where they are: as the engine left them, but for what a
    /// stop, a stick or a caller has set since. A state that is not a number ends the run as diverged.
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
