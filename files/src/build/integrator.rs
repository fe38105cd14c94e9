//! The default integrator of a machine.

use feeler_engine::Integrator;
use feeler_plant::assembly::assemble;
use feeler_plant::description::Machine;

/// Largest number of bodies for the exact integrator: beyond, ten steps of RK4 take less time than one of its
/// products (docs/performance.md).
pub const EXACT_PAYS_UP_TO_BODIES: usize = 32;
/// Largest product of step and fastest rate. RK4 is stable up to 2.78; here its error is 1/120 of a radian in
/// each radian of the fastest motion.
const FAST: f64 = 1.0;

/// The default integrator: the exact one. Beyond [`EXACT_PAYS_UP_TO_BODIES`] bodies it is RK4 if the step is
/// short enough.
pub(crate) fn by_default(machine: &Machine, step_s: f64) -> Integrator {
    let many = machine.bodies.len() > EXACT_PAYS_UP_TO_BODIES;
    if many && longest_step_s(machine).is_some_and(|longest| step_s <= longest) {
        Integrator::Rk4
    } else {
        Integrator::Exact
    }
}

/// The longest step with which RK4 follows every motion of a machine; `None` if an unlimited stiffness allows
/// no step.
pub fn longest_step_s(machine: &Machine) -> Option<f64> {
    let rate = assemble(machine).ok()?.fastest_rate_per_s();
    (rate > 0.0 && rate.is_finite()).then_some(FAST / rate)
}
