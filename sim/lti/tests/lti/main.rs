//! Linear systems: against closed forms, laws for all systems, and known responses.
#![cfg(test)]

mod chains;
mod common;
mod machines;
mod margins;
mod properties;
mod sines;
mod spectral;
