//! What a run leaves behind.

use feeler_engine::Trace;

/// Joint events that are kept.
pub(crate) const MOST_EVENTS: usize = 1_000_000;

/// A joint that stuck or broke loose, or whose play met a flank or left it.
#[derive(Clone, Debug, PartialEq)]
pub struct JointEvent {
    /// When, s.
    pub t_s: f64,
    /// Which joint.
    pub joint: usize,
    /// `stick`, `slip`, `touch` or `lift`.
    pub what: &'static str,
}

/// The signals of a run.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Force, compression and command along the normal, readings, and whether a joint's torque was at its limit (`joints.limited`), at the rate of the measures;
    /// with the contact's events.
    pub measures: Trace,
    /// The same, and joints, tool, point of contact and normal, at the rate of the file.
    pub motion: Trace,
    /// What happened in the joints.
    pub joint_events: Vec<JointEvent>,
}
