//! Limits of a loop: stable gains, margins, chatter, drive limits, and what limits the bandwidth.

pub(crate) mod drift;
pub(crate) mod factor;
pub(crate) mod flexible;
pub(crate) mod limit_cycle;
pub(crate) mod locus;
pub(crate) mod margins;
pub(crate) mod saturation;
pub(crate) mod sensitivity;
pub(crate) mod stability;
pub(crate) mod waterfall;
