//! Roles of columns in a dataset.

/// Meaning of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColumnRole {
    /// Desired position of the joint.
    Target,
    /// Desired speed, beside the desired position.
    TargetVelocity,
    /// Torque or force that a servo adds to that of its loop.
    FeedForward,
    /// Its place.
    Position,
    /// How fast it is.
    Velocity,
    /// Torque, force or current, as reported.
    Effort,
    /// Torque, force or current, as commanded.
    Command,
}

impl ColumnRole {
    /// Its name in sentences, and as a column of a dataset.
    pub fn noun(self) -> &'static str {
        match self {
            Self::Target => "target",
            Self::TargetVelocity => "target-velocity",
            Self::FeedForward => "feed-forward",
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Effort => "effort",
            Self::Command => "command",
        }
    }

    /// Whether it is an input of a servo besides its target.
    pub(super) fn feeds_servo(self) -> bool {
        matches!(self, Self::TargetVelocity | Self::FeedForward)
    }
}
