//! Locates the gap between a machine and its model, and finds the unmodelled effect that causes the gap and
//! how far it closes.
//!
//! [`dataset::Dataset::load`] reads and checks records; [`diagnose`] answers;
//! [`predict::Predictor`] replays a record on any machine.

pub mod adequacy;
mod answer;
pub mod blind;
mod budget;
mod chance;
pub mod dataset;
mod diagnose;
mod error;
mod examination;
mod filter;
mod fit;
mod frf;
mod gap;
pub mod import;
mod inverse;
mod judge;
mod kinds;
pub mod predict;
pub mod report;
mod sets;
mod tolerance;

pub use answer::difference;
pub use budget::Budget;
pub use diagnose::{diagnose, diagnose_within};
pub use error::DiagnosisError;
pub use examination::Examination;
pub use frf::measured_response;
pub use gap::replay;
pub use gap::size::closing;
pub use kinds::apart;
pub use report::Diagnosis;
