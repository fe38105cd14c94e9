//! Actions at instants: clocks, controllers, drives, sensors and delayed readings.

pub(crate) mod clock;
mod control_loop;
pub(crate) mod drive;
pub(crate) mod reading;
pub(crate) mod sampler;
pub(crate) mod sampling;
pub(crate) mod sensing;
pub(crate) mod servo_loop;
pub(crate) mod taps;
