//! The simulation held against closed forms, other people's numbers, and the paper's claims.

pub mod error;
pub mod models;
pub mod paper;
pub mod table;

pub use error::ValidationError;
pub use table::{Row, Table};
