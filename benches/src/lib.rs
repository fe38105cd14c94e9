//! The benchmarks and their references.
//!
//! [`machines`] contains the machines, [`hand_written`] the loops that an expert would write for exactly
//! these machines. [`batch`] runs many variants in lanes and on threads, [`stopwatch`] compares two pieces of
//! work fairly on a noisy machine.

pub mod batch;
pub mod hand_written;
pub mod machines;
pub mod peak;
pub mod stopwatch;
