//! Bound on the fastest motion of a machine.

use std::f64::consts::TAU;

use super::{Assembly, Drive, GROUND_NODE, NodeId};
use crate::description::{Engagement, LowPass};

impl Assembly {
    /// A bound on the modulus of every eigenvalue of the machine in any state of contact, 1/s; infinite if a
    /// stiffness has no limit.
    ///
    /// Gershgorin's circles bound `M^-1 K` by twice the largest sum of stiffnesses at a body over its mass,
    /// and `M^-1 C` in the same way. A motion of `s^2 = -C s - K` then has `|s|^2 <= |C| |s| + |K|`. Drives
    /// and filters are in series with the bodies, so their own rates are separate bounds.
    pub fn fastest_rate_per_s(&self) -> f64 {
        let lags = self.drives.iter().flat_map(|drive| &drive.lags).map(|lag| 1.0 / lag);
        let heats =
            self.drives.iter().filter_map(|drive| drive.warming).map(|warming| 1.0 / warming.time_constant);
        let sources =
            self.drives.iter().filter_map(|drive| drive.velocity_source).map(|source| source.time_constant);
        let sources = sources.filter(|lag| *lag > 0.0).map(|lag| 1.0 / lag);
        let filters = self.sensors.iter().flat_map(|sensor| &sensor.filters).map(LowPass::fastest_rate_per_s);
        let integrals =
            self.drives.iter().filter_map(Drive::continuous_servo).map(|servo| servo.ki / servo.kp);
        lags.chain(heats)
            .chain(sources)
            .chain(filters)
            .chain(integrals)
            .fold(self.fastest_motion_per_s(), f64::max)
    }

    fn fastest_motion_per_s(&self) -> f64 {
        let mut held = vec![[0.0; 2]; self.nodes.len()];
        let mut hold = |ends: [NodeId; 2], by: [f64; 2]| {
            for end in ends {
                held[end][0] += by[0];
                held[end][1] += by[1];
            }
        };
        for link in self.links.iter().filter(|link| !link.rigid) {
            let is_bounded = link.cubic <= 0.0 && link.drag <= 0.0 && link.bristle.is_none();
            let stiffness = if is_bounded { link.stiffness } else { f64::INFINITY };
            let steepest = link.over_speed.map_or(0.0, |table| table.stiffness());
            hold([link.a, link.b], [stiffness, link.damping * (1.0 + link.asymmetry.abs()) + steepest]);
        }
        for weight in &self.weights {
            hold([weight.on, weight.reacts_on], [weight.course.stiffness(), 0.0]);
        }
        for contact in self.contacts.iter().filter(|contact| contact.engagement != Engagement::Free) {
            let stiffness = if contact.law.is_linear() { contact.law.stiffness } else { f64::INFINITY };
            hold([contact.a, contact.b], [stiffness, contact.law.damping]);
        }
        for drive in &self.drives {
            let source = drive.velocity_source.map_or(0.0, |source| source.damping);
            let line = drive.line.map_or(0.0, |line| line.slope);
            let [stiffness, damping] =
                drive.continuous_servo().map_or([0.0; 2], |servo| [servo.kp, servo.kd]);
            hold([drive.on, drive.reacts_on], [stiffness, source + line + damping]);
        }
        let of = |(node, held): (NodeId, &[f64; 2])| {
            let [stiffness, damping] =
                held.map(|sum| if sum > 0.0 { 2.0 * sum / self.nodes[node].mass_kg } else { 0.0 });
            0.5 * (damping + (damping * damping + 4.0 * stiffness).sqrt())
        };
        held.iter().enumerate().filter(|(node, _)| *node != GROUND_NODE).map(of).fold(0.0, f64::max)
    }
}

impl LowPass {
    /// A bound on the modulus of its poles, 1/s.
    fn fastest_rate_per_s(&self) -> f64 {
        match *self {
            Self::FirstOrder { corner_hz } => TAU * corner_hz,
            Self::SecondOrder { corner_hz, damping_ratio } => 2.0 * TAU * corner_hz * damping_ratio.max(1.0),
        }
    }
}
