//! The linear view of a machine against closed forms and against the simulation.

mod account;
mod chains;
mod closed_loop;
mod common;
mod delays;
mod feed_through;
mod frf;
mod linearise;
mod loops;
mod servos;
