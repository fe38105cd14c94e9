//! A machine seen by linear theory: derived from the very machine that is simulated, so that the two can be
//! held against each other.
//!
//! - [`LinearMachine`]: small motions about an operating point, any command to any signal, delays exact
//!   beside it;
//! - [`ControlLoop`]: the machine with its controllers, as a [`SampledLoop`] (hold, fractional delays,
//!   filters, several rates: exact) and as a [`ContinuousLoop`]; stable values of any gain, and what happens
//!   at each edge;
//! - [`modes()`] and [`classify`]: the paper's colocated and noncolocated modes, and the phase that each
//!   costs;
//! - [`Waterfall`]: which of the three problems limits the bandwidth, and what to stiffen or damp first;
//! - [`limit_cycles`]: chatter of a contact that only pushes, by describing functions;
//! - [`frf`]: frequency responses measured on the simulated machine, the linear response beside them;
//! - [`analyze`]: all of it as one [`Report`], and [`curves()`], what a page draws of it.
//!
//! Source: Eppinger and Seering, "Three Dynamic Problems in Robot Force Control", IEEE Trans. Robotics and
//! Automation 8 (1992).

mod assumptions;
mod channel;
mod closed_loop;
mod continuous_law;
mod continuous_loop;
mod control_loop;
mod curves;
mod drift;
mod equilibrium;
mod error;
pub mod frf;
mod gain_key;
mod late;
mod limit_cycle;
mod linearise;
mod locus;
mod loop_pair;
mod margins;
mod modes;
mod outer_force;
mod prepare;
mod report;
mod sampled_loop;
mod saturation;
mod schedule;
mod sensitivity;
mod stability;
mod waterfall;

pub use assumptions::Assumption;
pub use channel::Channel;
pub use closed_loop::{ClosedLoop, Shelf};
pub use continuous_loop::ContinuousLoop;
pub use control_loop::{ControlLoop, LoopController};
pub use curves::{Curves, curves};
pub use equilibrium::OperatingPoint;
pub use error::AnalysisError;
pub use gain_key::{gain, gain_names, leading_gain, with_gain};
pub use late::LateResponse;
pub use limit_cycle::{LimitCycle, limit_cycles};
pub use linearise::{LinearMachine, OutputRow};
pub use locus::Locus;
pub use loop_pair::LoopReport;
pub use margins::MarginReport;
pub use modes::{BodyMotion, Mode, ModeClass, ModeInPair, classify, modes};
pub use prepare::{ContactView, FrictionView, HeldCommand, PlayView, View};
pub use report::{GainReport, ModeReport, Report, Request, StableRange, StateSpaceReport, Untold, analyze};
pub use sampled_loop::SampledLoop;
pub use sensitivity::{RankedBy, Sensitivity};
pub use stability::{Band, Edge, GainBands};
pub use waterfall::{Limit, Relief, Stage, Waterfall};
