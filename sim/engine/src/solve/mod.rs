//! One mode of one machine: its equations, their exact solution, and the location of guard crossings.

pub(crate) mod crossing;
pub(crate) mod decay;
pub(crate) mod exponentials;
pub(crate) mod extrapolation;
pub(crate) mod flow;
pub(crate) mod flows;
mod polynomial;
pub(crate) mod taylor;
