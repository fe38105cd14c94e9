//! feeler-lti
mod assignment;
mod balance;
mod discretise;
mod domain;
mod eigen;
mod error;
mod expm;
mod gain_interval;
mod interconnect;
mod response;
mod root_locus;
mod search;
mod state_space;
mod zero_pole_gain;
mod zeros;

pub use balance::{Balanced, balance};
pub use discretise::zero_order_hold_response;
pub use domain::{C64, Continuous, Discrete, TimeDomain};
pub use eigen::{Eigen, damping_ratio, eigen, eigenvalues, frequencies_hz};
pub use error::LtiError;
pub use expm::{ExponentialIntegrals, expm, expm_action, expm_integrals, taylor_coefficients};
pub use gain_interval::{AffineLoop, GainEdge, GainSearch, StableGains, StableInterval, stable_gains};
pub use response::{TransferEvaluator, unwrapped_phase_rad};
pub use root_locus::{RootLocus, root_locus};
pub use state_space::{DiscreteStateSpace, StateSpace};
pub use zero_pole_gain::ZeroPoleGain;
