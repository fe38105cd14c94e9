//! The `feeler` command.
fn main() {}
