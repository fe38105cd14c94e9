//! `loop-gain`: a servo whose loop is weaker or stronger than believed.

use feeler_plant::description::Actuator;
use feeler_plant::effects::{Kind, LoopGain};

use super::start::off;
use super::{Element, Glance, Known, Seen};
use crate::tolerance::FRACTION;

/// Trial gains. The units of a firmware may be off by decades, and a fit converges from within a factor of
/// three.
const GAINS: [f64; 9] = [0.003, 0.01, 0.03, 0.1, 0.3, 0.6, 1.6, 5.0, 20.0];

impl Known for LoopGain {
    const APART: &'static [(Kind, &'static str)] = &[(
        Kind::AddedMass,
        "hold a known load: the error of the servo is the load over its gain, whatever the mass",
    )];

    /// For a drive with a force command, `drive-gain` has the same effect.
    fn starts(element: &Element<'_>, _: &Glance) -> Vec<Self> {
        if !element.is_servo() {
            return Vec::new();
        }
        GAINS.map(|gain| Self { gain }).to_vec()
    }

    fn is_trivial(self, element: &Element<'_>, _: Seen) -> bool {
        off(self.gain, 1.0) <= element.tolerance(&Actuator::SERVO_KP.key, FRACTION)
    }
}
