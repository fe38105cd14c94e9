//! Figures taken from a record.

pub(crate) mod chatter;
pub(crate) mod contact;
pub(crate) mod controlled;
pub(crate) mod energy;
pub(crate) mod force_loop;
pub(crate) mod saturation;
pub(crate) mod settling;
pub(crate) mod standing;
pub(crate) mod stiction;
pub(crate) mod strobe;
pub(crate) mod trend;
pub(crate) mod turns;
pub(crate) mod winding;
