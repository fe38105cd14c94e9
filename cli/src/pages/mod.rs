//! Pages of the commands, assembled from common parts.

pub(crate) mod analyze;
pub(crate) mod arm_run;
pub(crate) mod blind;
pub(crate) mod compare;
pub(crate) mod diagnosis;
pub(crate) mod frf;
pub(crate) mod live;
pub(crate) mod parts;
pub(crate) mod reduce;
pub(crate) mod run;
pub(crate) mod sweep;
pub(crate) mod tune;
pub(crate) mod why;
