//! The linear view of a machine against closed forms and against the simulation.

mod common;
mod frf;
mod linearise;
mod loops;
