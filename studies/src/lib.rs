//! Studies of scenarios: runs and their outcomes, sweeps, frequency responses, reasons of chatter, tuning,
//! reduction of arms.

pub mod arm;
pub mod frf;
pub mod glimpse;
pub mod numbers;
pub mod operating_point;
pub mod run;
pub mod signals;
pub mod sweep;
pub mod tune;
pub mod why;

mod doubts;
mod refusal;
mod threads;
mod unwritable;
mod whole_file;

pub use doubts::{Doubts, doubts};
pub use refusal::Refusal;
pub use threads::ALL_PROCESSORS;
pub use unwritable::unwritable;
pub use whole_file::write_whole;
