//! Where a gap between machine and model lies, which unmodelled effect causes it, and how far it shrinks.

pub mod dataset;
mod candidates;
mod error;
mod fit;
mod model;
pub mod predict;
pub mod search;
mod starts;

pub use error::DiagnosisError;
