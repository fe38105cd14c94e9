//! What a run must be, against closed forms, other people's numbers and laws that hold for every machine.

mod common;
mod divergence;
mod drives;
mod effects;
mod energy;
mod friction;
mod impacts;
mod lanes;
mod machines;
mod order;
mod play;
mod random;
mod reference_contact;
mod scaling;
mod sensing;
