//! What each command's page shows.

pub(crate) mod run;
