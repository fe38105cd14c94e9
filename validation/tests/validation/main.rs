//! The simulation against closed forms, other people's numbers and the paper.

mod checks;
mod engines;
mod figures;
mod files;
mod full;
mod fuzz;
mod landmarks;
mod models;
