//! The commands, one file each.

pub(crate) mod analyze;
pub(crate) mod blind;
pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod diagnose;
pub(crate) mod effects;
pub(crate) mod figures;
pub(crate) mod fit_landmarks;
pub(crate) mod frf;
pub(crate) mod import;
pub(crate) mod live;
pub(crate) mod merge;
pub(crate) mod new;
mod operating_point;
pub(crate) mod reduce;
pub(crate) mod replay;
pub(crate) mod run;
mod run_arm;
mod run_folder;
pub(crate) mod schema;
pub(crate) mod sweep;
mod swept;
pub(crate) mod tune;
pub(crate) mod validate;
pub(crate) mod why;
