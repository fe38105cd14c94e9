//! The simulation compared with closed forms, independent numbers, and the paper's claims.
//!
//! [`validate`] makes every check and returns a [`CheckTable`]. The modules contain the checks: `truths`
//! the closed forms, [`paper`] the paper's machines and the independent table of their numbers. [`files`]
//! has those machines from their scenario files, [`experiments`] measured responses and onsets. [`engines`]
//! has both engines side by side, [`claims`] the paper's five claims, [`landmarks`] a machine with the
//! paper's measured landmarks. [`figures`] draws the paper's figures.

pub mod claims;
pub mod closed_forms;
pub mod convergence;
pub mod engines;
pub mod error;
pub mod experiments;
pub mod figures;
pub mod files;
pub mod landmarks;
pub mod models;
pub mod paper;
pub mod random_machines;
pub mod svg;
pub mod table;
mod truths;
mod validate;

pub use error::ValidationError;
pub use table::{CheckRow, CheckTable, RowKind};
pub use validate::{ONSET_DELAYS, ValidateOptions, validate};
