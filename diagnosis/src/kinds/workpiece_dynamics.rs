//! `workpiece-dynamics`: a flexible workpiece.

use std::f64::consts::TAU;

use feeler_plant::effects::{Parameters, WorkpieceDynamics};

use super::start::is_overdamped;
use super::{Element, Glance, Known, Seen};

/// Trial frequencies and damping ratio of the workpiece alone.
const FREQUENCIES_HZ: [f64; 5] = [40.0, 70.0, 110.0, 170.0, 260.0];
const RATIO: f64 = 0.06;

impl Known for WorkpieceDynamics {
    fn starts(element: &Element<'_>, _: &Glance) -> Vec<Self> {
        // The records determine the series stiffness of contact and workpiece well, so a wrong stiffness
        // hides a right frequency. Both are therefore varied, and the mass follows.
        let contacts = element.machine.contacts.values().map(|contact| contact.stiffness);
        let softest = contacts.fold(f64::INFINITY, f64::min);
        let contact = if softest.is_finite() { softest } else { Self::typical().stiffness };
        let at = |stiffness: f64| {
            FREQUENCIES_HZ.map(|frequency_hz| {
                let omega = TAU * frequency_hz;
                Self {
                    mass: stiffness / (omega * omega),
                    stiffness,
                    damping: 2.0 * RATIO * stiffness / omega,
                }
            })
        };
        [3.0, 7.0, 16.0].into_iter().flat_map(|factor| at(factor * contact)).collect()
    }

    fn is_trivial(self, _: &Element<'_>, _: Seen) -> bool {
        is_overdamped(self.mass, self.stiffness, self.damping)
    }
}
