//! The outcomes of a run and their evidence; [`crate::run::verdict`] decides between them.

use serde::{Serialize, Serializer};

/// An undecided run is extended by doubling, up to this many times its duration.
pub const MOST_EXTENSION: f64 = 8.0;

/// What became of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Outcome {
    /// At rest, and never left the workpiece since the first touch.
    Settled,
    /// At rest after at least one loss of contact.
    BouncesThenSettles,
    /// Leaves the workpiece repeatedly.
    Chatter,
    /// Grows.
    Unstable,
    /// Oscillates between limits of drive or controller or, without contact, within a free play.
    LimitCycle,
    /// Sticks and breaks loose repeatedly.
    Hunting,
    /// Oscillates in contact without limits or stiction.
    Oscillates,
    /// Follows a reference that moves to the end.
    Driven,
    /// Keeps contact with a surface that moves to the end, and the force follows.
    FollowsSurface,
    /// Never touches, or no longer.
    NoContact,
    /// This run does not decide it.
    Undecided,
}

impl Outcome {
    /// Every outcome with its name in files.
    pub const ALL: [(Self, &'static str); 11] = [
        (Self::Settled, "settled"),
        (Self::BouncesThenSettles, "bounces-then-settles"),
        (Self::Chatter, "chatter"),
        (Self::Unstable, "unstable"),
        (Self::LimitCycle, "limit-cycle"),
        (Self::Hunting, "hunting"),
        (Self::Oscillates, "oscillates"),
        (Self::Driven, "driven"),
        (Self::FollowsSurface, "follows-surface"),
        (Self::NoContact, "no-contact"),
        (Self::Undecided, "undecided"),
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(outcome, _)| *outcome == self).map_or("", |(_, name)| name)
    }

    /// Whether the force comes to rest, or follows a reference or a surface that moves.
    pub fn is_stable(self) -> bool {
        matches!(self, Self::Settled | Self::BouncesThenSettles | Self::Driven | Self::FollowsSurface)
    }

    /// Whether the force oscillates to the end.
    pub fn is_sustained(self) -> bool {
        matches!(self, Self::Chatter | Self::LimitCycle | Self::Hunting | Self::Oscillates)
    }
}

impl Serialize for Outcome {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// Why a run is undecided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Undecided {
    /// Too little of the run follows the first touch or the last change of the reference.
    TooShort,
    /// Bounces or oscillations die out but have not ended.
    StillDecaying,
    /// The tool leaves the workpiece too rarely to decide.
    TooFewBounces,
    /// The tool is still on its way to the workpiece, or pressed on it by an approach that has not ended.
    StillApproaching,
    /// The force rests away from its reference, and a command moves on: something sticks and will break
    /// loose.
    StillWinding,
    /// The oscillation grows, and its bound is not visible yet.
    StillGrowing,
    /// The run stopped: too many events at one instant.
    EventStorm,
}

impl Undecided {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::TooShort => "too-short",
            Self::StillDecaying => "still-decaying",
            Self::TooFewBounces => "too-few-bounces",
            Self::StillApproaching => "still-approaching",
            Self::StillWinding => "still-winding",
            Self::StillGrowing => "still-growing",
            Self::EventStorm => "event-storm",
        }
    }

    /// Whether a longer run may decide.
    pub(crate) fn may_be_decided(self) -> bool {
        self != Self::EventStorm
    }
}

/// An outcome and its evidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// What became of the run.
    pub outcome: Outcome,
    /// Start and end of the judged time, s.
    pub tail_s: [f64; 2],
    /// Amplitudes of the three parts of the tail, N.
    pub amplitudes_n: [f64; 3],
    /// Rate at which the amplitude grows, 1/s, if it does.
    pub growth_per_s: Option<f64>,
    /// Why the run is undecided, if it is.
    pub undecided: Option<Undecided>,
}

impl Verdict {
    /// Whether a longer run may decide.
    pub(in crate::run) fn may_be_decided(&self) -> bool {
        self.undecided.is_some_and(Undecided::may_be_decided)
    }
}
