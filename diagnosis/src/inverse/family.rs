//! Families of smooth forces that no effect of the library makes.

use feeler_plant::effects::Place;

/// The quantities on which a smooth force depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    /// Position, speed and direction, as polynomials of low degree, with friction that drifts evenly.
    Motion,
    /// Position and direction in detail, as at a tight spot.
    Places,
    /// Time and direction, as in a guide that warms.
    Time,
    /// The command.
    Command,
}

impl Family {
    pub(super) const ALL: [Self; 4] = [Self::Motion, Self::Places, Self::Time, Self::Command];

    pub(super) fn place(self) -> Place {
        if self == Self::Command { Place::Drive } else { Place::Guide }
    }
}
