//! Where a run stands when it ends: what is still under way then.

use feeler_lanes::{Lane, LaneMask};
use feeler_plant::motion::{Row, dot};

use crate::run::simulation::{Simulation, take_lane};

impl<L: Lane> Simulation<L> {
    /// Whether some controller of a lane was in its approach at its last sample, so that its law did not run.
    pub fn is_approaching(&self, lane: usize) -> bool {
        self.loops.iter().any(|used| used.has_sampled() && !used.controller.in_contact_phase().test(lane))
    }

    /// How far each contact of a lane is compressed at the present time, m (negative across a gap), how fast
    /// that grows, m/s, and how fast this does, m/s2 (without the part of laws that are not linear).
    pub fn compressions(&self, lane: usize) -> Vec<[f64; 3]> {
        let mut xi = Vec::new();
        take_lane(&self.xi, lane, &mut xi);
        let flow = self.lanes[lane].flow();
        let rows = &flow.equations.compression;
        let of = |[compression, rate]: &[Row; 2]| {
            [dot(compression, &xi), dot(rate, &xi), dot(&flow.slope(rate), &xi)]
        };
        rows.iter().map(of).collect()
    }
}
