//! Studies of scenarios: outcomes, sweeps, tuning, reasons, whole arms.

mod arms;
mod cells;
mod common;
mod controller_code;
mod events;
mod frf;
mod glimpse;
mod limit_cycles;
mod outcomes;
mod peaks;
mod remedies;
mod scenario_files;
mod sizes;
mod stiction;
mod surfaces;
mod sweeps;
mod tune;
mod untouched;
mod why;
