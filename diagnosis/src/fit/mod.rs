//! Fits of a machine with unknowns to records, and the search among candidate effects.

pub(crate) mod balanced;
pub(crate) mod bounded;
pub(crate) mod candidates;
pub(crate) mod coarse;
pub(crate) mod curvature;
mod elongation;
mod first_steps;
pub(crate) mod glance;
pub(crate) mod least_squares;
mod leeway;
pub(crate) mod missing;
pub(crate) mod model;
mod nested;
mod noise_alone;
pub(crate) mod odds;
mod residuals;
pub(crate) mod sandwich;
pub(crate) mod scored;
pub(crate) mod screen;
pub(crate) mod search;
pub(crate) mod shared_scale;
pub(crate) mod tabled;
pub(crate) mod unknown;
mod walk;
pub(crate) mod wander;
pub(crate) mod weights;
pub(crate) mod yielding;
