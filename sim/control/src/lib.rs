//! Sampled-data control: what a robot's controller computes at its sample instants.
//!
//! A [`ControllerSpec`] is what the file says, in SI units. [`Controller`] is its compiled form for
//! `L::WIDTH` variants side by side; it is fed one set of [`Inputs`] per sample and gives the command that
//! the engine applies `delay_s` later and holds until the next (zero-order hold). When the samples are taken
//! is [`SampleClock`]'s business, what the loop shall follow is a [`Reference`]'s, and both draw their
//! randomness from a [`Stream`] of their own, so that no element's draws depend on which others are present.
//!
//! ```
//! use feeler_control::{Controller, ControllerSpec, ForceGains, Inputs, Law, Reference, ReferenceSpec,
//! SampleClock};
//!
//! // Proportional-integral force control of 20 N, sampled at 1 kHz.
//! let gains = ForceGains { kp: 0.6, ki: 25.0, ..ForceGains::default() };
//! let spec = ControllerSpec { reference: ReferenceSpec::Constant(20.0),
//! ..ControllerSpec::new(Law::ExplicitForce(gains), 1e-3) }; let (seed, name) = (1, "controllers.force");
//! let clock = SampleClock::new(&spec, seed, name)?;
//! let reference = Reference::new(&spec.reference, seed, name)?;
//! let mut controller = Controller::<f64>::new(&[spec])?;
//!
//! let t_s = clock.sample_time_s(0);
//! let command_n = controller.sample(t_s, &Inputs { reading: 15.0, ..Inputs::default() },
//! reference.value(t_s)); assert!((command_n - (0.6 * 5.0 + 25.0 * 1e-3 * 5.0)).abs() < 1e-12);
//! # Ok::<(), feeler_control::ControlError>(())
//! ```
//!
//! Every difference equation below is written as `x[n+1] = f(x[n], in[n])`, `y[n] = g(x[n], in[n])`, with `T`
//! the nominal period.

mod admittance;
mod approach;
mod controller;
mod error;
pub mod filter;
mod impedance;
mod law;
mod linear;
mod listing;
mod motion;
pub mod noise;
mod pid;
pub mod reference;
mod spec;
mod timing;

pub use controller::{Controller, Inputs};
pub use error::ControlError;
pub use law::{AdmittanceGains, AntiWindup, ForceGains, ImpedanceGains, Law, LeadSpec, PositionGains, READS};
pub use linear::LinearLaw;
pub use listing::{Line, Listing};
pub use noise::Stream;
pub use reference::{Reference, ReferenceSpec};
pub use spec::{Approach, ControllerSpec, LowPassSpec, NotchSpec};
pub use timing::SampleClock;
