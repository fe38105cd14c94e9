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
    /// The command and the speed, as in a drive near its largest voltage.
    Fading,
}

impl Family {
    /// The families without a shape to be fitted.
    pub(super) const PLAIN: [Self; 5] = [Self::Motion, Self::Places, Self::Time, Self::Command, Self::Fading];

    pub(crate) fn place(self) -> Place {
        if self.is_in_drive() { Place::Drive } else { Place::Guide }
    }

    pub(super) fn is_in_drive(self) -> bool {
        matches!(self, Self::Command | Self::Fading)
    }

    /// Number of unknowns.
    pub(crate) fn unknowns(self) -> usize {
        match self {
            Self::Motion => 13,
            Self::Places => 2 * NODES,
            Self::Waves { .. } => 3,
            Self::Time => 2 + FADES.len(),
            Self::Command => 3,
            Self::Fading => 2,
        }
    }
}
