//! Predicts the readings of a machine row by row from the recorded commands.
//!
//! The equations of motion are those of [`feeler_plant::motion`]; here they are advanced along a record.
//! Between rows the command is held, so that the exponential of each linear mode is exact; events in between
//! are located. A sampled command that varies between rows is replaced by its mean. At each row the rigid
//! motion may be corrected to the measured one (see `anchor.rs`). The remaining error is then the force that
//! the machine lacks, and not its accumulated effect.

mod anchor;
mod begin;
mod bristle;
mod close;
mod flow;
mod imposed;
mod leeway;
mod load;
mod loops;
mod machine;
mod prediction;
mod presliding;
mod run;
mod sensor;
mod starting;
mod state;
mod warm;

pub(crate) use anchor::{Anchoring, chain};
pub(crate) use begin::pace;
pub(crate) use leeway::{Leeway, MOST_LATE_ROWS};
pub use prediction::Prediction;
pub(crate) use presliding::Presliding;
pub use run::Predictor;
pub(crate) use run::Start;
pub(crate) use sensor::in_steps;
