//! Sampled-data control: the computations of a robot's controller at its sample instants.
//!
//! A [`ControllerSpec`] holds the contents of a file in SI units. [`Controller`] is its compiled form for
//! `L::WIDTH` variants side by side. It takes one set of [`Inputs`] per sample and returns a command. The
//! engine applies the command `delay_s` later and holds it until the next (zero-order hold). A
//! [`SampleClock`] determines the sample instants, a [`Reference`] the desired value. Both draw random
//! numbers from a [`Stream`] of their own, so an element's draws do not depend on the other elements.
//!
//! ```
//! use feeler_control::{Controller, ControllerSpec, ForceGains, Inputs, Law, Reference, ReferenceSpec,
//!     SampleClock};
//!
//! // Proportional-integral force control of 20 N, sampled at 1 kHz.
//! let gains = ForceGains { kp: 0.6, ki: 25.0, ..ForceGains::default() };
//! let spec = ControllerSpec { reference: ReferenceSpec::Constant(20.0),
//!     ..ControllerSpec::new(Law::ExplicitForce(gains), 1e-3) };
//! let (seed, name) = (1, "controllers.force");
//! let clock = SampleClock::new(&spec, seed, name)?;
//! let reference = Reference::new(&spec.reference, seed, name)?;
//! let mut controller = Controller::<f64>::new(&[spec])?;
//!
//! let t_s = clock.sample_time_s(0);
//! let command_n = controller.sample(t_s, &Inputs { reading: 15.0, ..Inputs::default() },
//!     reference.value(t_s));
//! assert!((command_n - (0.6 * 5.0 + 25.0 * 1e-3 * 5.0)).abs() < 1e-12);
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

pub use feeler_catalogue::GainPart;

pub use controller::{Controller, Inputs};
pub use error::ControlError;
pub use law::{
    ANTI_WINDUP, AdmittanceGains, AntiWindup, ForceGains, ImpedanceGains, Law, LeadSpec, PositionGains, READS,
};
pub use linear::LinearLaw;
pub use listing::{Line, Listing};
pub use noise::{Draws, Stream};
pub use reference::{Reference, ReferenceSpec};
pub use spec::{Approach, ControllerSpec, LowPassSpec, NotchSpec};
pub use timing::SampleClock;
