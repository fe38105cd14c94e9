//! What is around the simulator: the files that describe machines and experiments.

pub mod arm;
pub mod format;
pub mod operating_point;
pub mod run;
pub mod sweep;
pub mod why;

mod whole_file;

pub use whole_file::write_whole;
