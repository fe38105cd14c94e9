//! The answer from the results of the search, and the recommended next experiment.

mod attempts;
mod causes;
pub(crate) mod compose;
pub mod difference;
mod errors;
mod hidden;
mod intervals;
pub(crate) mod next;
mod presliding;
mod proposed;
mod signs;
mod tabled;
pub(crate) mod templates;
