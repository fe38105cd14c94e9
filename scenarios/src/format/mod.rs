//! Files that people write: machines and scenarios, sweeps, datasets.
//!
//! A plain number is SI, a text carries a unit. Every mistake of a file is found before anything runs, and all of them are reported together, each
//! with its line, key and remedy. Keys are declared once, in `keys`, one line each; parsing, the JSON Schema and the written reference follow from
//! these lines, and those of effects from the effects library.
//!
//! ```
//! use feeler_scenarios::format::Document;
//!
//! let text = r#"
//! [bodies.slide]
//! mass = "500 g"
//! [springs.wall]
//! between = ["ground", "slide"]
//! stiffness = "20 N/mm"
//! "#;
//! let document = Document::parse(text, "slide.toml")?;
//! assert_eq!(document.scenario.machine.springs["wall"].stiffness_n_per_m, 2e4);
//! # Ok::<(), feeler_scenarios::format::FormatError>(())
//! ```

mod build;
mod dimension;
mod document;
mod draft;
mod keys;
mod problem;
mod read;
mod report;
mod shape;
mod source;
mod suggest;
mod tree;
mod units;

pub use document::{Document, Place};
pub use draft::{Draft, Setting};
pub use problem::{FormatError, Located};
