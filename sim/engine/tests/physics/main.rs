//! What a run must be, against closed forms, other people's numbers and laws that hold for every machine.

mod common;
mod drives;
mod energy;
mod friction;
mod impacts;
mod lanes;
mod order;
mod play;
mod reference_contact;
mod sensing;
