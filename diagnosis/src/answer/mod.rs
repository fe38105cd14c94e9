//! What the search found, as an answer, and the experiment that should follow.

pub(crate) mod compose;
pub mod difference;
mod intervals;
pub(crate) mod next;
pub(crate) mod templates;
