//! Instants of discrete actions.

use feeler_plant::description::Profile;

/// Instants closer than this are equal, s: far below any event tolerance, far above the rounding of sums of
/// periods and delays.
pub const SAME_INSTANT_S: f64 = 1e-12;

/// Whether an instant is due at `t_s`.
#[inline(always)]
pub fn due(instant_s: f64, t_s: f64) -> bool {
    instant_s <= t_s + SAME_INSTANT_S
}

/// The start times of the pieces of one moving gap.
#[derive(Clone, Debug)]
pub(crate) struct GapClock {
    starts_s: Vec<f64>,
    /// Index of the next start time.
    next: usize,
}

impl GapClock {
    pub(crate) fn new(profile: &Profile) -> Self {
        let starts_s: Vec<f64> = profile.pieces().iter().map(|piece| piece.start_s).collect();
        let next = starts_s.partition_point(|&start_s| due(start_s, 0.0));
        Self { starts_s, next }
    }

    /// Advances to the piece that contains `t_s`; returns whether it is a new one.
    pub(crate) fn advance(&mut self, t_s: f64) -> bool {
        let before = self.next;
        while due(self.next_s(), t_s) {
            self.next += 1;
        }
        self.next != before
    }

    pub(crate) fn next_s(&self) -> f64 {
        self.starts_s.get(self.next).copied().unwrap_or(f64::INFINITY)
    }
}
