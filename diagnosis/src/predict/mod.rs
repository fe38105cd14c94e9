//! Predicts the readings of a machine, sample by sample, driven by the recorded command.
//!
//! The equations of motion are those of [`feeler_plant::motion`]; here they are stepped along a record.
//! Between rows the command is held, so that each linear mode is carried exactly by its exponential; events
//! in between are located. Samples of a command that goes on between rows are held at its mean. At each row
//! the rigid motion may be corrected to what was measured (see `anchor.rs`), which cuts the loop. The error
//! that remains is then a force that the machine lacks, not its consequences.

mod anchor;
mod begin;
mod close;
mod flow;
mod imposed;
mod leeway;
mod loops;
mod machine;
mod presliding;
mod run;
mod sensor;
mod state;
mod warm;

pub(crate) use anchor::{Anchoring, chain};
pub(crate) use begin::pace;
pub(crate) use leeway::Leeway;
pub(crate) use presliding::Presliding;
pub(crate) use run::Start;
pub use run::{Prediction, Predictor};
