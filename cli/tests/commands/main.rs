//! The binary as its users see it: its output, its files, and its exit codes.

#[cfg(test)]
mod arm;
#[cfg(test)]
mod bench;
#[cfg(test)]
mod check;
#[cfg(test)]
mod diagnose;
#[cfg(test)]
mod frf;
#[cfg(test)]
mod live;
#[cfg(test)]
mod print;
#[cfg(test)]
mod records;
#[cfg(test)]
mod reduce;
#[cfg(test)]
mod run;
#[cfg(test)]
#[cfg(target_os = "linux")]
mod slurm;
#[cfg(test)]
mod sweep;
#[cfg(test)]
mod theory;
#[cfg(test)]
mod tune;
#[cfg(test)]
mod why;
