//! Start, end and successor of a mode: the hybrid semantics that every machine shares.
//!
//! Each switch has a state of its own type ([`ContactState`], [`FrictionState`], [`DirectionState`],
//! [`LimitState`], [`RampState`]). Their rules apply to numbers and rows alike. A [`Guard`] gives the end of
//! a mode, [`first_crossing`] its instant, [`Motion::switch`] the next mode, and [`Motion::begin`] the mode
//! of a given state. An integrator only carries the state between these.
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
pub use crossing::{AT_ZERO, AT_ZERO_S, GuardFunction, Instant, first_crossing, may_dip, trace};
pub use guard::{Guard, GuardValue};
pub use rules::Signed;
pub use state::{ContactState, DirectionState, FrictionState, LimitState, Mode, RampState, SwitchState};
pub use storm::Storm;
pub use switch::Switch;
pub(super) use switch::switches;
