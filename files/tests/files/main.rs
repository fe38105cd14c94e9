//! Files: what is read, refused, written and told about them.

mod documents;
mod limits;
mod machine;
mod mistakes;
mod reports;
mod schema;
mod written;
