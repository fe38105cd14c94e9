//! Controllers, filters, references and noise: against closed forms, and on lanes.

mod approach;
mod filters;
mod lanes;
mod laws;
mod linear;
mod manual;
mod noise;
mod references;
