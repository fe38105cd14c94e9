//! Where a gap between machine and model lies, which unmodelled effect causes it, and how far it shrinks.
//!
//! [`dataset::Dataset::load`] reads and checks what was measured; [`diagnose`] answers;
//! [`predict::Predictor`] replays a record on any machine.

mod answer;
pub mod blind;
mod bounded;
mod candidates;
mod curvature;
pub mod dataset;
mod diagnose;
pub mod difference;
mod error;
mod fit;
mod gap;
mod intervals;
mod ladder;
mod laps;
mod locate;
mod model;
mod nested;
mod next;
mod odds;
pub mod predict;
mod rattle;
pub mod replay;
pub mod report;
mod screen;
mod search;
mod starts;
mod templates;
mod tolerance;
mod unknown;

pub use diagnose::diagnose;
pub use error::DiagnosisError;
pub use gap::closing;
pub use report::Diagnosis;
