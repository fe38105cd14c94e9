//! `torque-speed-line`: a drive that weakens with speed.

use feeler_plant::effects::{ABOVE_ZERO, Kind, TorqueSpeedLine};

use super::{Element, Glance, Known, Seen};

/// Trial forces at rest, as shares of the largest command.
const FORCES: [f64; 4] = [0.3, 0.6, 1.0, 2.0];
/// Trial no-load speeds, over the largest speed. Beyond twice that speed, less than half of the line is
/// visible.
const SPEEDS: [f64; 3] = [1.0, 1.3, 2.0];
/// Ratio of the no-load speed to the largest speed above which the line counts as a constant limit: at most a
/// tenth of the force is lost.
const LEVEL: f64 = 10.0;

impl Known for TorqueSpeedLine {
    const APART: &'static [(Kind, &'static str)] =
        &[(Kind::ForceLimit, "push with the largest command at rest and at speed: one cap falls with speed")];

    /// An amplifier with a force command has enough voltage, and a motor already states its line.
    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        if !element.is_servo() {
            return Vec::new();
        }
        let speed = glance.speed.max(ABOVE_ZERO);
        let of =
            |share: f64| SPEEDS.map(|times| Self { force: share * glance.command, speed: times * speed });
        FORCES.into_iter().flat_map(of).filter(|line| line.force > 0.0).collect()
    }

    fn is_trivial(self, _: &Element<'_>, seen: Seen) -> bool {
        self.speed > LEVEL * seen.speed_m_per_s
    }
}

#[cfg(test)]
mod tests {
    use feeler_plant::description::{ElementKind, Machine, Site};
    use indexmap::IndexMap;

    use super::*;

    #[test]
    fn truth_a_line_that_hardly_falls_over_the_motion_is_a_limit() {
        let machine = Machine::default();
        let tolerance = IndexMap::new();
        let element = Element::at(Site { table: ElementKind::Actuators, index: 0 }, &machine, &tolerance);
        let seen = Seen { speed_m_per_s: 2.0, ..Seen::default() };
        let of = |speed| TorqueSpeedLine { force: 40.0, speed };
        assert!(of(21.0).is_trivial(&element, seen) && !of(19.0).is_trivial(&element, seen));
    }
}
