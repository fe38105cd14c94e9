//! What each switch does: which quantities are positive while it stays in its state, and where it goes when
//! one of them no longer is.
//!
//! A quantity is a number where the motion is integrated as it is (an arm's), and a row of the extended
//! vector where modes are linear.

use super::{ContactState, DirectionState, FrictionState, LimitState, RampState};
use crate::assembly::ForceLaw;
use crate::motion::Row;
use crate::motion::layout::scaled;

/// A quantity of which the opposite can be taken.
pub trait Signed {
    /// The quantity times -1.
    #[must_use]
    fn opposite(&self) -> Self;
}

impl Signed for f64 {
    fn opposite(&self) -> Self {
        -self
    }
}

impl Signed for Row {
    fn opposite(&self) -> Self {
        scaled(-1.0, self)
    }
}

impl ContactState {
    /// The state of surfaces that were put `depth` deep into each other: pushing, until the law is asked.
    pub fn at(depth: f64) -> Self {
        if depth > 0.0 { Self::Pushing } else { Self::Open }
    }

    /// What is positive while a contact pushes, and what follows: with damping the force vanishes while the
    /// contact is still compressed; without, it vanishes with the depth, or with the `factor` by which the
    /// rate changes it.
    pub fn while_pushing<Q: Clone>(
        law: &ForceLaw,
        depth: &Q,
        force: impl FnOnce() -> Q,
        factor: impl FnOnce() -> Q,
    ) -> Vec<(Q, Self)> {
        if law.damping > 0.0 {
            return vec![(force(), Self::Releasing)];
        }
        let released = (law.alpha > 0.0).then(|| (factor(), Self::Releasing));
        [(depth.clone(), Self::Open)].into_iter().chain(released).collect()
    }

    /// Where one side of a free play goes when its law no longer pushes: without damping it opens.
    pub fn after_flank(damping: f64) -> Self {
        if damping > 0.0 { Self::Releasing } else { Self::Open }
    }

    /// What is positive while surfaces `depth` deep in each other stay in this state, and what follows.
    /// `pushing`: what is positive while the law pushes, and what follows there.
    ///
    /// Surfaces meet when their depth is no longer negative. A law that would pull lets go: its surfaces are
    /// releasing until it would push again, or until they are apart.
    pub fn guards<Q: Signed + Clone>(
        self,
        depth: &Q,
        pushing: impl FnOnce() -> Vec<(Q, Self)>,
    ) -> Vec<(Q, Self)> {
        match self {
            Self::Open => vec![(depth.opposite(), Self::Pushing)],
            Self::Pushing => pushing(),
            Self::Releasing => {
                // Surfaces that release are compressed: only their rate can make them push again.
                let rate = pushing().into_iter().find(|(_, next)| *next == Self::Releasing);
                let again = rate.map(|(quantity, _)| (quantity.opposite(), Self::Pushing));
                again.into_iter().chain([(depth.clone(), Self::Open)]).collect()
            }
        }
    }
}

impl FrictionState {
    /// The state of a guide that was given a speed; at rest it sticks, until the forces on it are asked.
    pub fn at(speed: f64) -> Self {
        match speed {
            v if v > 0.0 => Self::Forward,
            v if v < 0.0 => Self::Backward,
            _ => Self::Stick,
        }
    }

    /// Where a guide goes that has come to rest: `room` is what friction could still take forward and
    /// backward if the guide stuck.
    pub fn after_rest(room: [f64; 2]) -> Self {
        match room {
            [forward, _] if forward < 0.0 => Self::Forward,
            [_, backward] if backward < 0.0 => Self::Backward,
            _ => Self::Stick,
        }
    }

    /// What is positive while a guide of this speed stays in this state, and what follows: `None` where the
    /// guide comes to rest, and [`Self::after_rest`] decides.
    pub fn guards<Q: Signed + Clone>(
        self,
        speed: &Q,
        room: impl FnOnce() -> [Q; 2],
    ) -> Vec<(Q, Option<Self>)> {
        match self {
            Self::Forward => vec![(speed.clone(), None)],
            Self::Backward => vec![(speed.opposite(), None)],
            Self::Stick => {
                let [forward, backward] = room();
                vec![(forward, Some(Self::Forward)), (backward, Some(Self::Backward))]
            }
        }
    }
}

impl DirectionState {
    /// The direction of a speed.
    pub fn at(speed: f64) -> Self {
        match speed {
            v if v > Self::REST_M_PER_S => Self::Forward,
            v if v < -Self::REST_M_PER_S => Self::Backward,
            _ => Self::AtRest,
        }
    }

    /// What is positive while a guide of this speed stays in this state, and what follows. `room`: how far
    /// the speed is from where forward and backward begin.
    pub fn guards<Q: Signed + Clone>(self, speed: &Q, room: impl FnOnce() -> [Q; 2]) -> Vec<(Q, Self)> {
        match self {
            Self::Forward => vec![(speed.clone(), Self::AtRest)],
            Self::Backward => vec![(speed.opposite(), Self::AtRest)],
            Self::AtRest => {
                let [forward, backward] = room();
                vec![(forward, Self::Forward), (backward, Self::Backward)]
            }
        }
    }
}

impl LimitState {
    /// What is positive while the effort stays in this state, and what follows. `room`: how far the effort is
    /// from its upper and lower limit; `rate`: how fast it would rise without one.
    pub fn guards<Q: Signed>(self, room: impl FnOnce() -> [Q; 2], rate: Q) -> Vec<(Q, Self)> {
        match self {
            Self::Within => {
                let [upper, lower] = room();
                vec![(upper, Self::AtUpper), (lower, Self::AtLower)]
            }
            Self::AtUpper => vec![(rate, Self::Within)],
            Self::AtLower => vec![(rate.opposite(), Self::Within)],
        }
    }

    /// The effort that a limit of this size holds; `None` within it.
    pub fn effort(self, limit: f64) -> Option<f64> {
        match self {
            Self::Within => None,
            Self::AtUpper => Some(limit),
            Self::AtLower => Some(-limit),
        }
    }
}

impl RampState {
    /// The state of a command that has `left` to go to its target.
    pub fn towards(left: f64) -> Self {
        match left {
            l if l > 0.0 => Self::Rising,
            l if l < 0.0 => Self::Falling,
            _ => Self::AtTarget,
        }
    }

    /// What is positive while the command stays in this state, and what follows.
    pub fn guards<Q: Signed>(self, left: impl FnOnce() -> Q) -> Vec<(Q, Self)> {
        match self {
            Self::AtTarget => Vec::new(),
            Self::Rising => vec![(left(), Self::AtTarget)],
            Self::Falling => vec![(left().opposite(), Self::AtTarget)],
        }
    }

    /// Slope of a command that changes by no more than `rate_limit`.
    pub fn slope(self, rate_limit: f64) -> f64 {
        match self {
            Self::AtTarget => 0.0,
            Self::Rising => rate_limit,
            Self::Falling => -rate_limit,
        }
    }
}
