//! The states of switches, and the mode that they form.

use super::Switch;

/// State of two surfaces that only push: a contact, or one side of a free play.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum ContactState {
    /// Apart.
    #[default]
    Open = 0,
    /// Compressed, and the law pushes.
    Pushing = 2,
    /// Still compressed, but parting faster than the law pushes: no force.
    Releasing = 1,
}

/// State of dry friction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum FrictionState {
    /// Friction holds the guide at rest.
    #[default]
    Stick = 0,
    /// Friction resists a guide that slides forward.
    Forward = 2,
    /// Friction resists a guide that slides backward.
    Backward = 1,
}

/// State of an effort at its limit, or of an error at its deadband.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum LimitState {
    /// The limit is not reached.
    #[default]
    Within = 0,
    /// Held at the upper limit.
    AtUpper = 2,
    /// Held at the lower limit.
    AtLower = 1,
}

/// State of the command of a drive with limited rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum RampState {
    /// The command has reached its target.
    #[default]
    AtTarget = 0,
    Rising = 2,
    Falling = 1,
}

/// Direction of a guide whose resistance depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum DirectionState {
    /// Slower than [`DirectionState::REST_M_PER_S`].
    #[default]
    AtRest = 0,
    Forward = 2,
    Backward = 1,
}

impl DirectionState {
    /// A slower guide is at rest, m/s (rad/s). Its resistance vanishes with its speed, so the neglected part
    /// is rounding.
    pub const REST_M_PER_S: f64 = 1e-12;

    /// Sign of the speed.
    pub fn sign(self) -> f64 {
        match self {
            Self::AtRest => 0.0,
            Self::Forward => 1.0,
            Self::Backward => -1.0,
        }
    }
}

/// The state of one switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SwitchState {
    /// State of a contact, or of one side of a free play.
    Contact(ContactState),
    /// State of a guide with dry friction.
    Friction(FrictionState),
    /// State of an effort limit, a speed line or a deadband.
    Limit(LimitState),
    Ramp(RampState),
    /// State of a guide whose resistance differs by direction.
    Direction(DirectionState),
}

macro_rules! states {
    ($($switch:ident($state:ident),)*) => {
        impl SwitchState {
            fn bits(self) -> u8 {
                match self {
                    $(Self::$switch(state) => state as u8,)*
                }
            }
        }

        $(impl From<$state> for SwitchState {
            fn from(state: $state) -> Self {
                Self::$switch(state)
            }
        })*
    };
}

states! {
    Contact(ContactState),
    Friction(FrictionState),
    Limit(LimitState),
    Ramp(RampState),
    Direction(DirectionState),
}

/// The states of all switches, two bits each. By default everything is open, stuck, within its limit and at
/// its target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Mode(u128);

impl Mode {
    /// The most switches a machine may have.
    pub(crate) const CAPACITY: usize = 64;

    /// The state of switch `i`, a contact or one side of a free play.
    pub fn contact(self, i: usize) -> ContactState {
        [ContactState::Open, ContactState::Releasing, ContactState::Pushing][self.index(i)]
    }

    /// The state of switch `i`, a guide with dry friction.
    pub fn friction(self, i: usize) -> FrictionState {
        [FrictionState::Stick, FrictionState::Backward, FrictionState::Forward][self.index(i)]
    }

    /// The state of switch `i`, an effort limit.
    pub fn limit(self, i: usize) -> LimitState {
        [LimitState::Within, LimitState::AtLower, LimitState::AtUpper][self.index(i)]
    }

    /// The state of switch `i`, a rate limit.
    pub fn ramp(self, i: usize) -> RampState {
        [RampState::AtTarget, RampState::Falling, RampState::Rising][self.index(i)]
    }

    /// The state of switch `i`, a guide whose resistance differs by direction.
    pub fn direction(self, i: usize) -> DirectionState {
        [DirectionState::AtRest, DirectionState::Backward, DirectionState::Forward][self.index(i)]
    }

    /// The state of switch `i`, which is one of `switch`.
    pub fn state(self, switch: Switch, i: usize) -> SwitchState {
        match switch {
            Switch::Contact(_) | Switch::Stop(..) => self.contact(i).into(),
            Switch::Friction(_) => self.friction(i).into(),
            Switch::Limit(_) | Switch::Line(_) | Switch::Deadband(_) => self.limit(i).into(),
            Switch::Ramp(_) => self.ramp(i).into(),
            Switch::Direction(_) => self.direction(i).into(),
        }
    }

    fn index(self, i: usize) -> usize {
        // No state is written as 3.
        ((self.0 >> (2 * i)) & 3).min(2) as usize
    }

    /// This mode with switch `i` in another state.
    #[must_use]
    pub fn with(self, i: usize, state: impl Into<SwitchState>) -> Self {
        Self(self.0 & !(3 << (2 * i)) | (u128::from(state.into().bits()) << (2 * i)))
    }
}
