//! Linear analysis of a machine. The model is derived from the simulated machine itself, so theory and
//! simulation can be compared directly.
//!
//! - [`LinearMachine`]: small motions about an operating point, from any command to any signal; delays are
//!   exact and kept apart from the state space;
//! - [`ControlLoop`]: the machine with its controllers, as a [`SampledLoop`] (exact holds, fractional delays,
//!   filters and several rates) and as a [`ContinuousLoop`]. It gives the stable values of any gain, and what
//!   happens at each edge;
//! - [`modes()`] and [`classify`]: the paper's colocated and noncolocated modes, and the phase that each
//!   costs;
//! - [`Waterfall`]: which of the three problems limits the bandwidth, and what to stiffen or damp first;
//! - [`limit_cycles`]: chatter of a contact that only pushes, by describing functions;
//! - [`frf`]: frequency responses measured on the simulated machine, with the linear response beside them;
//! - [`analyze`]: all of this as one [`Report`]; [`curves()`] gives the curves of a page.
//!
//! Source: Eppinger and Seering, "Three Dynamic Problems in Robot Force Control", IEEE Trans. Robotics and
//! Automation 8 (1992).

mod error;
mod limits;
mod loops;
mod machine;
mod measure;
mod report;
mod workers;

pub use error::AnalysisError;
pub use limits::limit_cycle::{LimitCycle, limit_cycles};
pub use limits::locus::Locus;
pub use limits::margins::MarginReport;
pub use limits::sensitivity::{RankedBy, Sensitivity};
pub use limits::stability::{Band, Edge, GainBands};
pub use limits::waterfall::{Limit, Relief, Stage, Waterfall};
pub use loops::closed_loop::{ClosedLoop, Shelf};
pub use loops::continuous_loop::ContinuousLoop;
pub use loops::control_loop::{ControlLoop, LoopController};
pub use loops::gain_key::{gain, gain_names, leading_gain, with_gain};
pub use loops::late::LateResponse;
pub use loops::loop_pair::LoopPair;
pub use loops::sampled_loop::SampledLoop;
pub use loops::step_response::StepResponse;
pub use machine::assumptions::Assumption;
pub use machine::channel::ResponseChannel;
pub use machine::equilibrium::OperatingPoint;
pub use machine::linearise::{LinearMachine, OutputRow};
pub use machine::modes::{BodyMotion, ModeClass, ModeInPair, VibrationMode, classify, modes};
pub use machine::prepare::{ContactView, FrictionView, HeldCommand, PlayView, View};
pub use measure::curves::{Curves, curves};
pub use measure::frf;
pub use report::{
    GainReport, LoopReport, ModeReport, Report, Request, StableRange, StateSpaceReport, WhyNoWaterfall,
    analyze,
};
pub use workers::Workers;
