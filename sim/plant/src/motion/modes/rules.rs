//! Rules of each switch: the quantities that are positive while it stays in its state, and its next state
//! when one is not.
//!
//! A quantity is a number if the motion is integrated directly (an arm's), and a row of the extended vector
//! if modes are linear.

use super::{ContactState, DirectionState, FrictionState, LimitState, RampState};
use crate::assembly::ForceLaw;
use crate::motion::Row;
use crate::motion::layout::scaled;

/// A quantity with a sign that can be reversed.
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
    /// The state of surfaces with penetration `depth`: pushing, until the law is evaluated.
    pub fn at(depth: f64) -> Self {
        if depth > 0.0 { Self::Pushing } else { Self::Open }
    }

    /// The quantities that are positive while a contact pushes, and the next state. With damping the force
    /// vanishes while the contact is still compressed. Without, it vanishes with the depth, or with the
    /// `factor` by which the rate changes it.
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

    /// The next state of one side of a free play when its law no longer pushes: without damping it opens.
    pub fn after_flank(damping: f64) -> Self {
        if damping > 0.0 { Self::Releasing } else { Self::Open }
    }

    /// The quantities that are positive while surfaces with penetration `depth` stay in this state, and the
    /// next state. `pushing` gives those of the law while it pushes.
    ///
    /// Surfaces meet when their depth is no longer negative. A law that would pull releases: its surfaces are
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
                // Releasing surfaces are compressed: only their rate can make them push again.
                let rate = pushing().into_iter().find(|(_, next)| *next == Self::Releasing);
                let again = rate.map(|(quantity, _)| (quantity.opposite(), Self::Pushing));
                again.into_iter().chain([(depth.clone(), Self::Open)]).collect()
            }
        }
    }
}

impl FrictionState {
    /// The state of a guide with a given speed; at rest it sticks, until its forces are evaluated.
    pub fn at(speed: f64) -> Self {
        match speed {
            v if v > 0.0 => Self::Forward,
            v if v < 0.0 => Self::Backward,
            _ => Self::Stick,
        }
    }

    /// The next state of a guide that has come to rest: `room` is the remaining friction, forward and
    /// backward, if the guide stuck.
    pub fn after_rest(room: [f64; 2]) -> Self {
        match room {
            [forward, _] if forward < 0.0 => Self::Forward,
            [_, backward] if backward < 0.0 => Self::Backward,
            _ => Self::Stick,
        }
    }

    /// The quantities that are positive while a guide of this speed stays in this state, and the next state.
    /// `None` if the guide comes to rest; [`Self::after_rest`] then decides.
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

    /// The quantities that are positive while a guide of this speed stays in this state, and the next state.
    /// `room`: distances of the speed from the start of forward and backward motion.
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
    /// The quantities that are positive while the effort stays in this state, and the next state. `room`:
    /// distances of the effort from its upper and lower limit; `rate`: its rate without a limit.
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

    /// The effort at a limit of this size; `None` within it.
    pub fn effort(self, limit: f64) -> Option<f64> {
        match self {
            Self::Within => None,
            Self::AtUpper => Some(limit),
            Self::AtLower => Some(-limit),
        }
    }
}

impl RampState {
    /// The state of a command at the distance `left` from its target.
    pub fn towards(left: f64) -> Self {
        match left {
            l if l > 0.0 => Self::Rising,
            l if l < 0.0 => Self::Falling,
            _ => Self::AtTarget,
        }
    }

    /// The quantities that are positive while the command stays in this state, and the next state.
    pub fn guards<Q: Signed>(self, left: impl FnOnce() -> Q) -> Vec<(Q, Self)> {
        match self {
            Self::AtTarget => Vec::new(),
            Self::Rising => vec![(left(), Self::AtTarget)],
            Self::Falling => vec![(left().opposite(), Self::AtTarget)],
        }
    }

    /// Slope of a command with the rate limit `rate_limit`.
    pub fn slope(self, rate_limit: f64) -> f64 {
        match self {
            Self::AtTarget => 0.0,
            Self::Rising => rate_limit,
            Self::Falling => -rate_limit,
        }
    }
}
