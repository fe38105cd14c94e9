//! `thermal-derating`: a drive that weakens as it warms.

use feeler_plant::effects::{Kind, ThermalDerating};

use super::{Element, Glance, Known};

/// Shortest record in which a winding warms noticeably, s.
const SHORTEST_S: f64 = 30.0;
/// Trial forces at which heat halves the force, over the largest force.
const FORCES: [f64; 2] = [0.6, 1.5];
/// Trial time constants, over the length of the longest record.
const TIMES: [f64; 2] = [0.2, 1.0];

impl Known for ThermalDerating {
    const APART: &'static [(Kind, &'static str)] = &[
        (Kind::LoopGain, "repeat one motion for minutes, rest, and repeat it: only a warm drive recovers"),
        (Kind::DriveGain, "repeat one motion for minutes, rest, and repeat it: only a warm drive recovers"),
        (Kind::ForceLimit, "hold a small force on the warm drive: a cap leaves it as it was"),
    ];

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        if glance.duration_s < SHORTEST_S || glance.command <= 0.0 {
            return Vec::new();
        }
        let of = |share: f64| {
            TIMES
                .map(|times| Self { force: share * glance.command, time_constant: times * glance.duration_s })
        };
        FORCES.into_iter().flat_map(of).collect()
    }
}
