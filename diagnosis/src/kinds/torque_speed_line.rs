//! `torque-speed-line`: a drive that weakens with speed.

use feeler_plant::effects::{ABOVE_ZERO, Kind, TorqueSpeedLine};

use super::{Element, Glance, Known};

/// Forces at rest tried, as shares of the largest command.
const FORCES: [f64; 4] = [0.3, 0.6, 1.0, 2.0];
/// Speeds without load tried, of the fastest motion: beyond twice, less than half of the line shows.
const SPEEDS: [f64; 3] = [1.0, 1.3, 2.0];

impl Known for TorqueSpeedLine {
    const APART: &'static [(Kind, &'static str)] =
        &[(Kind::ForceLimit, "push with the largest command at rest and at speed: one cap falls with speed")];

    /// An amplifier whose command is a force has voltage to spare, and a motor has a line of its own.
    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        if !element.is_servo() {
            return Vec::new();
        }
        let speed = glance.speed.max(ABOVE_ZERO);
        let of =
            |share: f64| SPEEDS.map(|times| Self { force: share * glance.command, speed: times * speed });
        FORCES.into_iter().flat_map(of).filter(|line| line.force > 0.0).collect()
    }
}
