//! Files: reading, refusing, writing and describing them.

mod documents;
mod limits;
mod machine;
mod mistakes;
mod reports;
mod schema;
mod written;

/// A machine with every kind of element.
const COMPLETE: &str = include_str!("../data/complete.toml");
