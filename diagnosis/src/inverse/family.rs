//! Families of smooth forces that no effect of the library makes.

use feeler_plant::effects::Place;

/// Nodes over the stroke between which a force that depends on position is linear.
pub(super) const NODES: usize = 9;
/// Time constants of a force that fades while a guide warms, as shares of the recorded time.
pub(super) const FADES: [f64; 2] = [0.05, 0.2];

/// The quantities on which a smooth force depends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Family {
    /// Position, speed and direction, as polynomials of low degree, with friction that drifts evenly.
    Motion,
    /// Position and direction in detail, as at a tight spot.
    Places,
    /// Position and direction: friction that repeats over the stroke, as with each turn of a screw.
    Waves { pitch_m: f64 },
    /// Time and direction, as in a guide that warms.
    Time,
    /// The command.
    Command,
    /// The speed: the drive makes its command times `1 - per_speed |v|`, as a motor near its largest voltage.
    Fading { per_speed: f64 },
}

impl Family {
    pub(crate) fn place(self) -> Place {
        if matches!(self, Self::Command | Self::Fading { .. }) { Place::Drive } else { Place::Guide }
    }

    /// Whether the force is evidence against causes at other places. Polynomials of the motion, position in
    /// detail, or a curve over the command come close to many causes.
    pub(super) fn is_distinct(self) -> bool {
        matches!(self, Self::Waves { .. } | Self::Time | Self::Fading { .. })
    }

    /// Number of unknowns.
    pub(super) fn unknowns(self) -> usize {
        match self {
            Self::Motion => 13,
            Self::Places => 2 * NODES,
            Self::Waves { .. } => 4,
            Self::Time => 2 + FADES.len(),
            Self::Command => 3,
            Self::Fading { .. } => 1,
        }
    }

    /// The dependence of the force in words.
    pub(crate) fn told(self) -> &'static str {
        match self {
            Self::Motion => "which follows position and speed",
            Self::Places => "which follows position",
            Self::Waves { .. } => "friction that repeats over the stroke",
            Self::Time => "friction that drifts with time",
            Self::Command => "which follows the command",
            Self::Fading { .. } => "which falls with speed",
        }
    }
}
