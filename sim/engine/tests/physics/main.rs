//! Runs against closed forms, published numbers, and laws that hold for every machine.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests fail as tests do, and say what they measured"
)]

mod common;
mod divergence;
mod drives;
mod effects;
mod energy;
mod extreme;
mod friction;
mod impacts;
mod lanes;
mod laws;
mod machines;
mod moving_gap;
mod order;
mod play;
mod random;
mod reference_contact;
mod scaling;
mod sensing;
mod series;
mod servos;
mod stepping;
