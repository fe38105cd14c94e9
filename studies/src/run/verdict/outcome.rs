//! The outcomes of a run and their evidence; [`crate::run::verdict`] decides between them.

use serde::{Serialize, Serializer};

/// An undecided run is extended by doubling, up to this many times its duration.
pub const MOST_EXTENSION: f64 = 8.0;

/// Class of a run by its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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

    /// The outcome in a few words, as summaries and pages show it.
    pub fn words(self) -> &'static str {
        self.described().0
    }

    /// Its meaning, in sentences.
    pub fn meaning(self) -> &'static str {
        self.described().1
    }

    fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::Settled => (
                "settled",
                "The force comes to rest, and the tool never left the workpiece after first touch.",
            ),
            Self::BouncesThenSettles => (
                "bounces, then settles",
                "The force comes to rest after the tool has left the workpiece at least once.",
            ),
            Self::Chatter => (
                "sustained chatter",
                "The tool leaves the workpiece again and again, and this does not die out.",
            ),
            Self::Unstable => (
                "unstable",
                "The motion diverges, or grows while the tool stays in contact. It also covers growth that \
                 lasts to the end of a sweep's longest extension.",
            ),
            Self::LimitCycle => (
                "limit cycle through saturation or free play",
                "The force oscillates to the end. A drive or controller is at its limit for part of every \
                 cycle.",
            ),
            Self::Hunting => (
                "hunting through stiction",
                "The force oscillates to the end. A guide sticks and breaks loose again.",
            ),
            Self::Oscillates => (
                "sustained oscillation",
                "The force oscillates to the end in contact, without force limits or stiction.",
            ),
            Self::Driven => (
                "follows a moving reference",
                "The reference moves to the end, so there is nothing to settle at. It is shown as `follows \
                 its commands` if no controller regulates the force.",
            ),
            Self::FollowsSurface => (
                "follows a moving surface",
                "The surface moves to the end of the run and contact lasts. The force neither settles nor \
                 grows.",
            ),
            Self::NoContact => (
                "no contact",
                "The tool never touched and is not on its way. It is shown as `contact lost` if the tool \
                 touched, left and stayed away.",
            ),
            Self::Undecided => (
                "undecided",
                "The run is too short to tell. Its remark gives the reason, usually that `run.duration` \
                 should be longer.",
            ),
        }
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
    /// Every reason.
    pub const ALL: [Self; 7] = [
        Self::TooShort,
        Self::StillDecaying,
        Self::TooFewBounces,
        Self::StillApproaching,
        Self::StillWinding,
        Self::StillGrowing,
        Self::EventStorm,
    ];

    /// The reason as a clause about the run.
    pub fn words(self) -> &'static str {
        match self {
            Self::TooShort => "too few cycles follow the first touch or the last step of the reference",
            Self::StillDecaying => "the oscillation dies out but has not ended",
            Self::TooFewBounces => "the tool leaves the workpiece too rarely to judge",
            Self::StillApproaching => "the run ends while the tool still approaches the workpiece",
            Self::StillWinding => {
                "the force rests, but the integrator winds up and will break the guide loose"
            }
            Self::StillGrowing => "the oscillation still grows slowly",
            Self::EventStorm => "the run stopped at an instant with too many events",
        }
    }

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
    pub fn may_be_decided(self) -> bool {
        self != Self::EventStorm
    }
}

/// An outcome and its evidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RunVerdict {
    /// Class of the run, by its name.
    pub outcome: Outcome,
    /// Start and end of the judged time, s.
    pub tail_s: [f64; 2],
    /// Amplitudes of the three parts of the tail, N. They have the unit of `controlled` if that is present.
    pub amplitudes_n: [f64; 3],
    /// Rate at which the amplitude grows, 1/s, if it does.
    pub growth_per_s: Option<f64>,
    /// Why the run is undecided, if it is.
    pub undecided: Option<Undecided>,
    /// When a tool that still approaches would touch at its last speed, s.
    pub touches_at_s: Option<f64>,
}

impl RunVerdict {
    /// Whether a longer run may decide.
    pub(in crate::run) fn may_be_decided(&self) -> bool {
        self.undecided.is_some_and(Undecided::may_be_decided)
    }
}
