//! Tip, workpiece and state of the arm at the start.

use feeler_catalogue::{Dimension, Key, KeyKind, Unit, required};
use feeler_geometry::{Placement, Shape};

/// A shape at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Centred on its own origin.
    pub shape: Shape,
    /// Its place: for a tip in the tool's frame, for a workpiece in the base's.
    pub place: Placement,
}

/// State of the arm at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Joint positions, rad or m; gears are relaxed.
    pub pose: Vec<f64>,
    /// The direction of force control: from the tool into the workpiece, in the base's frame.
    pub normal: [f64; 3],
    /// Speed of the tool along the normal, m/s; all parts start as a rigid arm.
    pub speed_m_per_s: f64,
}

impl Part {
    /// The table of a tip in files.
    pub const TIP: &'static str = "tip";
    /// The table of a workpiece in files.
    pub const WORKPIECE: &'static str = "workpiece";
}

impl Start {
    /// Its table in files.
    pub const TABLE: &'static str = "start";
    /// The direction of force control.
    pub const NORMAL: Key = required(
        "normal",
        KeyKind::Numbers(Unit::Of(Dimension::NONE), 3),
        "from the tool into the workpiece, in the base's frame: the direction of force control",
    );
}
