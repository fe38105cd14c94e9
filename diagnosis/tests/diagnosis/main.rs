//! From records to causes: datasets, faults, predictions, answers.

mod adequacy;
mod beginning;
mod contradictions;
mod drives;
mod emps;
mod faults;
mod fuzz;
mod import;
mod inputs;
mod one_machine;
mod recovery;
mod surface;
