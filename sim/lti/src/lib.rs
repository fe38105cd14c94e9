//! Linear systems for force-controlled machines: the behaviour of springs, masses, actuators and sampled
//! controllers near an operating point, as exact as double precision allows.
//!
//! - [`StateSpace`] in [`Continuous`] or [`Discrete`] time, connected in series and feedback;
//! - [`expm`], its integrals, and exact discretisation: zero-order hold with any real delay;
//! - poles, transmission zeros, zero-pole-gain form, frequency response with exact delays;
//! - [`stable_gains`]: every interval of stable gains of a loop, and what happens at its edges;
//! - [`root_locus`]: closed-loop poles as a gain changes;
//! - [`LoopTransfer`]: margins, sensitivity peaks and Nyquist's count;
//! - [`spectral`]: frequency responses estimated from records, with their uncertainty.
//!
//! Inputs, outputs and states have the units of the caller. Time is in seconds. Frequencies are in Hz if the
//! name says so and otherwise in rad/s. This crate does not print, read files or start threads.
//!
//! # Example: how far may the gain of a sampled force loop rise?
//! ```
//! use feeler_lti::{AffineLoop, LoopTransfer, StateSpace};
//! use nalgebra::dmatrix;
//!
//! // From drive force to sensor force: 12 kg on a guide of 60 N s/m, a sensor of 2e5 N/m and 120 N s/m.
//! let (m, b, k) = (12.0, 180.0, 2e5);
//! let axis = StateSpace::new(dmatrix![0.0, 1.0; -k / m, -b / m],
//!     dmatrix![0.0; 1.0 / m], dmatrix![k, 0.0], dmatrix![0.0])?;
//!
//! // Continuous proportional control is stable at every gain ...
//! let continuous = AffineLoop::negative_feedback(&axis)?.stable_gains()?;
//! assert!(continuous.intervals[0].upper.is_none());
//!
//! // ... but at 1 kHz with one sample of delay it is not.
//! let sampled = axis.zero_order_hold_delayed(1e-3, 1e-3)?;
//! let stable = AffineLoop::negative_feedback(&sampled)?.stable_gains()?;
//! let edge = stable.intervals[0].upper.as_ref().expect("bounded");
//! assert!((edge.gain - 0.6067).abs() < 1e-4);
//!
//! // At half that gain the gain margin is two, whichever way it is computed.
//! let margins = LoopTransfer::discrete(&sampled.scaled(0.5 * edge.gain))?.margins()?;
//! assert!((margins.smallest_increase().expect("bounded").factor - 2.0).abs() < 1e-9);
//! # Ok::<(), feeler_lti::LtiError>(())
//! ```

mod assignment;
mod balance;
mod discretise;
mod domain;
mod eigen;
mod error;
mod expm;
mod francis;
mod gain_interval;
mod interconnect;
mod irreducible;
mod loop_transfer;
mod margins;
mod modal;
mod polish;
mod rank_one;
mod response;
mod root_locus;
mod search;
mod simulate;
pub mod spectral;
mod state_space;
mod vectors;
mod zero_pole_gain;
mod zeros;

pub use balance::{Balanced, balance};
pub use domain::{C64, Continuous, Discrete, TimeDomain};
pub use eigen::{Eigen, damping_ratio, eigen, eigenvalues, frequencies_hz};
pub use error::LtiError;
pub use expm::{ExponentialIntegrals, expm, expm_integrals};
pub use gain_interval::{AffineLoop, GainEdge, GainSearch, StableGains, StableInterval, stable_gains};
pub use loop_transfer::{LoopPoint, LoopTransfer};
pub use margins::{DiskMargin, GainMargin, LoopGainInterval, Margins, PhaseMargin, SensitivityPeak};
pub use rank_one::RankOneLoop;
pub use response::{TransferEvaluator, unwrapped_phase_rad};
pub use root_locus::{RootLocus, root_locus};
pub use state_space::{DiscreteStateSpace, StateSpace};
pub use zero_pole_gain::ZeroPoleGain;
