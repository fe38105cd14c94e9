//! Which integrator steps a machine where its file names none.

use feeler_engine::Integrator;
use feeler_plant::assembly::assemble;
use feeler_plant::description::Machine;

/// Bodies beyond which ten steps of RK4 take less time than one product of the exact integrator
/// (docs/performance.md).
pub const EXACT_PAYS_UP_TO_BODIES: usize = 32;
/// Largest product of step and fastest rate: RK4 is stable up to 2.78, and off by (1/120) of a radian in each
/// radian of the fastest motion here.
const FAST: f64 = 1.0;

/// The integrator where none is named: the exact one, and RK4 beyond [`EXACT_PAYS_UP_TO_BODIES`] bodies where
/// the step is short enough for it.
pub(crate) fn by_default(machine: &Machine, step_s: f64) -> Integrator {
    let many = machine.bodies.len() > EXACT_PAYS_UP_TO_BODIES;
    if many && longest_step_s(machine).is_some_and(|longest| step_s <= longest) {
        Integrator::Rk4
    } else {
        Integrator::Exact
    }
}

/// The longest step with which RK4 follows everything that a machine does; `None` where a stiffness without
/// limit tells none.
pub fn longest_step_s(machine: &Machine) -> Option<f64> {
    let rate = assemble(machine).ok()?.fastest_rate_per_s();
    (rate > 0.0 && rate.is_finite()).then_some(FAST / rate)
}
