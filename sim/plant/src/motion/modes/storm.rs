//! Detects many events at practically one instant.

/// Number of events at one instant after which time is advanced slightly: with rounding, two modes may each
/// require the other.
const EVENTS_BEFORE_PUSH: usize = 4;
/// The first advance, s; each further event at the instant doubles it.
const PUSH_S: f64 = 1e-13;
/// Number of events at one instant after which the run ends.
const EVENTS_BEFORE_STORM: usize = 60;
/// More events than this within [`STORM_S`] also end the run.
const MOST_EVENTS: usize = 1000;
/// One nanosecond per event: thousands of times shorter than the period of the fastest machine.
const STORM_S: f64 = 1e-6;

/// Counts the events at one instant, and detects more than any machine has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Storm {
    /// Start of a span of [`STORM_S`], and the number of events in it.
    recent: (f64, usize),
    at_instant: usize,
    has_switched: bool,
}

impl Storm {
    /// Begins a new span.
    pub fn begin(&mut self) {
        (self.at_instant, self.has_switched) = (0, false);
    }

    /// The advance of time past guards, if one is due; an evaluation follows it.
    pub fn push_s(&self) -> Option<f64> {
        (self.has_switched && self.at_instant >= EVENTS_BEFORE_PUSH)
            .then(|| PUSH_S * f64::from(1_u32 << (self.at_instant - EVENTS_BEFORE_PUSH).min(20)))
    }

    /// Records that time has advanced by `moved_s`.
    pub fn moved(&mut self, moved_s: f64, is_push: bool) {
        if !is_push && moved_s > 10.0 * PUSH_S {
            self.at_instant = 0;
        }
        self.has_switched = false;
    }

    /// Records that a guard has fired at `t_s`. Returns whether there are more events than any machine has.
    pub fn fired(&mut self, t_s: f64) -> bool {
        self.has_switched = true;
        self.at_instant += 1;
        if (t_s - self.recent.0).abs() > STORM_S {
            self.recent = (t_s, 0);
        }
        self.recent.1 += 1;
        self.at_instant > EVENTS_BEFORE_STORM || self.recent.1 > MOST_EVENTS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether some event of a series is one too many.
    fn storms(count: usize, apart_s: f64) -> bool {
        let mut storm = Storm::default();
        storm.begin();
        (0..count).any(|k| {
            let is_too_many = storm.fired(k as f64 * apart_s);
            storm.moved(apart_s, false);
            is_too_many
        })
    }

    #[test]
    fn truth_events_without_end_are_a_storm_and_fast_ones_are_not() {
        // At one instant.
        assert!(!storms(EVENTS_BEFORE_STORM, 0.0) && storms(EVENTS_BEFORE_STORM + 1, 0.0));
        // In a span of a microsecond, and as far apart as those of a motion at 100 MHz.
        assert!(!storms(MOST_EVENTS, 1e-10) && storms(MOST_EVENTS + 1, 9e-10));
        assert!(!storms(100_000, 1e-8));
    }
}
