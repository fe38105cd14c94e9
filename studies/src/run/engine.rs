//! The engine that moves the bodies of a run.

use feeler_engine::{BodyEngine, EngineError, Integrator, Program, Simulation};
use feeler_multibody::RapierBodies;
use feeler_plant::description::Axis;

/// One variant in its engine: Feeler's, or Rapier for the integrator [`Integrator::External`]. `axis` is that
/// of its machine.
///
/// # Errors
/// Those of [`Simulation::new`].
pub fn simulation(program: Program, axis: Axis) -> Result<Simulation<f64>, EngineError> {
    let mut bodies: Vec<Box<dyn BodyEngine>> = Vec::new();
    if program.settings().integrator == Integrator::External {
        bodies.push(Box::new(RapierBodies::new(program.motion(), axis)));
    }
    Simulation::with_bodies(vec![program], bodies)
}
