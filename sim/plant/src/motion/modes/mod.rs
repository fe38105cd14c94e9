//! When a mode begins, what ends it and what follows: the one hybrid semantics of every machine.
//!
//! Each switch has a state of its own type ([`ContactState`], [`FrictionState`],
//! [`DirectionState`], [`LimitState`], [`RampState`]); their rules stand beside them and hold for numbers and
//! for rows alike. A [`Guard`] says when a mode ends, [`first_crossing`] at which instant, [`Motion::switch`]
//! what follows, and [`Motion::begin`] in which mode a machine is that was put somewhere. Whoever moves a
//! machine carries its state between these, and nothing else.
//!
//! [`Motion::switch`]: super::Motion::switch
//! [`Motion::begin`]: super::Motion::begin

mod begin;
mod change;
mod crossing;
mod guard;
mod rules;
mod state;
mod storm;
mod switch;

pub use begin::Beginning;
pub(super) use change::joined;
pub use change::{ModeTable, Switched};
pub use crossing::{AT_ZERO, AT_ZERO_S, Course, Instant, first_crossing, may_dip, trace};
pub use guard::{Guard, GuardValue};
pub use rules::Signed;
pub use state::{ContactState, DirectionState, FrictionState, LimitState, Mode, RampState, SwitchState};
pub use storm::Storm;
pub(super) use switch::switches;
pub use switch::{StopSide, Switch};
