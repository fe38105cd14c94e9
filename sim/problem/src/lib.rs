//! Mistakes as data: what is wrong, where, and what to do about it.
//!
//! `Display` of an error states what is wrong and no more. The place and the remedy are separate values
//! ([`Remedy`]), so that no program has to parse a message.
//!
//! ```
//! use std::borrow::Cow;
//! use feeler_problem::Remedy;
//!
//! #[derive(Debug)]
//! struct TooLight {
//!     body: String,
//! }
//!
//! impl std::fmt::Display for TooLight {
//!     fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
//!         f.write_str("the mass is zero")
//!     }
//! }
//!
//! impl std::error::Error for TooLight {}
//!
//! impl Remedy for TooLight {
//!     fn place(&self) -> String {
//!         format!("bodies.{}.mass", self.body)
//!     }
//!
//!     fn remedy(&self) -> Cow<'_, str> {
//!         "write a mass above zero".into()
//!     }
//! }
//!
//! let problem = TooLight { body: "tip".into() }.problems().remove(0);
//! assert_eq!(problem.to_string(), "bodies.tip.mass: the mass is zero (write a mass above zero)");
//! ```

pub mod contract;
mod problem;
mod remedy;
pub mod sort;

pub use problem::{Problem, in_lines, short};
pub use remedy::Remedy;
