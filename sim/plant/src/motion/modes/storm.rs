//! Events that follow each other at practically one instant.

/// Events at one instant after which time is pushed on a little: rounding may leave two modes each asking for
/// the other.
const EVENTS_BEFORE_PUSH: usize = 4;
/// The first push, s; each further event at the instant doubles it.
const PUSH_S: f64 = 1e-13;
/// Events at one instant after which the run is given up.
const EVENTS_BEFORE_STORM: usize = 60;
/// More events than this within [`STORM_S`] are a storm, too.
const MOST_EVENTS: usize = 1000;
/// A nanosecond for each: thousands of times shorter than the period of the fastest machine.
const STORM_S: f64 = 1e-6;

/// Counts the events at one instant, and knows when there are more than any machine has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Storm {
    /// When a span of [`STORM_S`] began, and the events in it.
    recent: (f64, usize),
    at_instant: usize,
    has_switched: bool,
}

impl Storm {
    /// A new span begins.
    pub fn begin(&mut self) {
        (self.at_instant, self.has_switched) = (0, false);
    }

    /// How far time is to be pushed on, past guards, if it is; a nudge is followed by an evaluation.
    pub fn push_s(&self) -> Option<f64> {
        (self.has_switched && self.at_instant >= EVENTS_BEFORE_PUSH)
            .then(|| PUSH_S * f64::from(1_u32 << (self.at_instant - EVENTS_BEFORE_PUSH).min(20)))
    }

    /// Time has gone on by `moved_s`.
    pub fn moved(&mut self, moved_s: f64, is_push: bool) {
        if !is_push && moved_s > 10.0 * PUSH_S {
            self.at_instant = 0;
        }
        self.has_switched = false;
    }

    /// A guard has fired at `t_s`: whether there are more events than any machine has.
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
