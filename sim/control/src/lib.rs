//! Sampled-data control: what a robot's controller computes at its sample instants.
//!
//! A [`ControllerSpec`] is what the file says, in SI units. [`Controller`] is its compiled form for `L::WIDTH` variants side by side; it is
//! fed one set of [`Inputs`] per sample and gives the command that the engine applies `delay_s` later and holds until the next (zero-order
//! hold). When the samples are taken is [`SampleClock`]'s business, what the loop shall follow is a [`Reference`]'s, and both draw their
//! randomness from a [`Stream`] of their own, so that no element's draws depend on which others are present.
//!
//! Every difference equation below is written as `x[n+1] = f(x[n], in[n])`, `y[n] = g(x[n], in[n])`, with `T` the nominal period.

mod admittance;
mod approach;
mod controller;
mod error;
pub mod filter;
mod impedance;
mod linear;
mod motion;
pub mod noise;
mod pid;
pub mod reference;
mod spec;
mod timing;

pub use controller::{Controller, Inputs};
pub use error::ControlError;
pub use linear::LinearLaw;
pub use noise::Stream;
pub use reference::{Reference, ReferenceSpec};
pub use spec::{
    AdmittanceGains, AntiWindup, Approach, ControllerSpec, ForceGains, ImpedanceGains, Law, LeadSpec, LowPassSpec, PositionGains,
};
pub use timing::SampleClock;
