//! Logs as robots and their users write them.
//!
//! A log of any format is a list of [`Run`]s. A run has [`Table`]s with a clock each, and a table has named
//! [`Column`]s of numbers. An absent cell holds NaN and is counted; nothing is interpolated here.
//! [`on_one_grid`] then brings columns of several tables to common instants.
//!
//! ```no_run
//! use std::path::Path;
//!
//! for source in feeler_logs::sources(&[Path::new("bag.mcap")])? {
//!     for run in source.read()? {
//!         for table in &run.tables {
//!             assert!(table.rows() > 0, "{} at {:?} Hz", table.name, table.rate_hz());
//!         }
//!     }
//! }
//! # Ok::<(), feeler_logs::LogError>(())
//! ```

mod agreement;
mod arrays;
mod bag;
mod clock;
mod csv;
mod error;
mod grid;
mod json;
mod kind;
mod lerobot;
mod mcap;
mod packed;
mod pages;
mod parquet;
mod recordings;
mod ros;
mod source;
mod sqlite;
mod table;
mod topics;

pub use clock::{Clock, ClockUnit, median_step};
pub use error::{LogError, LogPlace};
pub use grid::{Pick, Series, on_one_grid};
pub use kind::Format;
pub use source::{LogSource, read_file, sources};
pub use table::{BadCells, Column, Run, Table};
