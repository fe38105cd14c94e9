//! The binary as users see it: its output, files, exit codes and book.
#![cfg(test)]

mod arm;
mod bench;
mod book;
mod check;
mod compare;
mod diagnose;
mod engines;
mod frf;
mod import;
mod live;
mod print;
mod records;
mod reduce;
mod requests;
mod run;
#[cfg(target_os = "linux")]
mod slurm;
mod sweep;
mod theory;
mod tune;
mod why;
