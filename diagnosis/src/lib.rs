//! Where a gap between machine and model lies, which unmodelled effect causes it, and how far it shrinks.

pub mod dataset;
mod error;
pub mod predict;

pub use error::DiagnosisError;
