//! Responses of a chain from the forces between its bodies, without a state space: about a hundred times
//! faster, for fits from many starts.

use std::f64::consts::TAU;

use feeler_lti::C64;
use nalgebra::{SMatrix, SVector};

use super::chain::{LINKS, LandmarkChain};

/// Base, motor, and the bodies after it.
const BODIES: usize = LINKS + 2;
const BASE: usize = 0;
const MOTOR: usize = 1;
const END: usize = BODIES - 1;

/// The measured output, per velocity commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Seen {
    /// Acceleration of the motor, free.
    Motor,
    /// Acceleration of the end-point, free.
    End,
    /// Force of the clamped sensor's spring.
    Force,
}

impl LandmarkChain {
    pub(super) fn response(&self, frequency_hz: f64, seen: Seen) -> C64 {
        let s = C64::new(0.0, TAU * frequency_hz);
        let link = |stiffness: f64, damping: f64| s * damping + stiffness;
        let mut z = SMatrix::<C64, BODIES, BODIES>::zeros();
        let masses = [self.base_kg, self.motor_kg].into_iter().chain(self.masses_kg);
        for (i, mass_kg) in masses.enumerate() {
            z[(i, i)] = s * s * mass_kg;
        }
        let [stiffness, damping] = self.mount_spring();
        z[(BASE, BASE)] += link(stiffness, damping);
        let source = C64::from(self.source[0]) / (s * self.source[1] + 1.0);
        let mut join = |i: usize, j: usize, force: C64| {
            for (a, b, part) in [(i, i, force), (j, j, force), (i, j, -force), (j, i, -force)] {
                z[(a, b)] += part;
            }
        };
        join(BASE, MOTOR, link(0.0, self.guide_n_s_per_m) + source * s);
        for i in 0..LINKS {
            join(MOTOR + i, MOTOR + i + 1, link(self.stiffness_n_per_m[i], self.damping_n_s_per_m[i]));
        }
        if seen == Seen::Force {
            join(END, BASE, link(self.sensor[0], self.sensor[1]));
        }
        let mut forces = SVector::<C64, BODIES>::zeros();
        (forces[MOTOR], forces[BASE]) = (source, -source);
        // Masses are above zero, so only an undamped machine at its resonance has no response.
        let Some(x) = z.lu().solve(&forces) else { return C64::new(f64::NAN, f64::NAN) };
        match seen {
            Seen::Motor => s * s * x[MOTOR],
            Seen::End => s * s * x[END],
            Seen::Force => (x[END] - x[BASE]) * self.sensor[0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_analysis::{LinearMachine, View};
    use feeler_plant::description::{Engagement, Quantity, SignalName};

    /// Two methods for one number, over a state matrix of condition 1e6.
    const TWO_WAYS: f64 = 1e-8;

    #[test]
    fn truth_forces_between_bodies_and_state_space_of_the_file_answer_alike() {
        for number in 0..4 {
            let chain = LandmarkChain::start(number);
            for (seen, engagement, element, quantity) in [
                (Seen::Motor, Engagement::Free, "motor", Quantity::Acceleration),
                (Seen::End, Engagement::Free, "link4", Quantity::Acceleration),
                (Seen::Force, Engagement::Clamped, "tool", Quantity::SpringForce),
            ] {
                let machine = LinearMachine::new(&chain.machine(engagement), &View::default()).unwrap();
                let channel = machine
                    .channel(
                        &SignalName::new("drive", Quantity::Command),
                        &SignalName::new(element, quantity),
                    )
                    .unwrap();
                let frequencies = [5.0, 12.1, 40.0, 73.0];
                let expected = channel.frequency_response(&frequencies).unwrap();
                for (f, expected) in frequencies.into_iter().zip(expected) {
                    let got = chain.response(f, seen);
                    assert!(
                        (got - expected).norm() < TWO_WAYS * expected.norm(),
                        "{seen:?} at {f} Hz: {got} instead of {expected}"
                    );
                }
            }
        }
    }
}
