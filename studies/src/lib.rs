//! What is done with scenarios: runs and their outcomes, sweeps, reasons of chatter, reduction of arms.

pub mod arm;
pub mod operating_point;
pub mod run;
pub mod sweep;
pub mod why;

mod whole_file;

pub use whole_file::write_whole;
