//! The commands, one file each.

pub(crate) mod check;
pub(crate) mod completions;
pub(crate) mod effects;
pub(crate) mod new;
pub(crate) mod run;
pub(crate) mod schema;
