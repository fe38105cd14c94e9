//! Files that people write: machines and scenarios, sweeps, datasets.
//!
//! A plain number is SI, a text has a unit. Every mistake of a file is found before anything runs. All of
//! them are reported together, each with its line, key and remedy. Keys are declared once, in `keys`, one
//! line each. Parsing, the JSON Schema and the written reference follow from these lines; effects follow from
//! the effects library.
//!
//! ```
//! use feeler_files::Document;
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
//! # Ok::<(), feeler_files::FormatError>(())
//! ```

mod arm;
mod build;
mod cell;
mod dataset;
mod document;
mod draft;
mod edit;
mod file;
mod followed;
mod gaps;
mod keys;
mod kind;
mod located;
mod numbers;
mod parse;
mod problem;
mod read;
#[cfg(test)]
mod reference;
mod report;
mod schema;
mod source;
mod sweep;
mod templates;
mod tree;
mod units;
mod write;

pub use arm::ArmFile;
pub use build::{EXACT_PAYS_UP_TO_BODIES, longest_step_s};
pub use cell::CellFile;
pub use dataset::DatasetFile;
pub use document::{Document, FilePlace};
pub use draft::{Draft, Setting, read_text};
pub use edit::{Assignment, assignment, settings_between};
pub use followed::followed_by;
pub use keys::EXAMPLE_KEY;
pub use keys::dataset as dataset_keys;
pub use keys::dataset::{ColumnSpec, Experiment, ExperimentRole, LogClock};
pub use keys::sweep::{Keep, Sampling};
pub use located::Located;
pub use numbers::{Edit, Number, rounded, with_numbers};
pub use problem::FormatError;
pub use schema::{cell_schema, dataset_schema, schema, sweep_schema};
pub use sweep::{MOST_DIMENSIONS, Refine, SweepAxis, SweepFile};
pub use templates::{ARM_TEMPLATE, FOLDERS, Folder, TEMPLATES, Template, arm_text, template, template_names};
pub use units::{ColumnUnit, UnitKind, column_unit};
pub use write::{Commands, driven_to_toml, machine_to_toml, samples_csv, to_toml};
