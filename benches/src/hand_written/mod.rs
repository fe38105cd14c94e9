//! The yardstick: the loop that an expert writes for exactly one machine.
//!
//! Each machine has its equations written out over plain numbers, and each method is one loop with everything
//! inlined. Nothing is looked up, checked or recorded except the peak force. The expert compiles for the
//! present processor, and so does the comparison with other simulators (`peers/hand_written.rs`). In the
//! benchmarks of this crate, compiled for any processor, the loops do not use fused multiply-adds.

mod control;
mod filtered_loop;
mod loops;
mod plants;

pub use control::{Control, Proportional, ProportionalIntegral};
pub use filtered_loop::FilteredLoop;
pub use loops::{Method, RunResult, run};
pub use plants::{Axis, FlexibleAxis, FlexibleCell, Plant};

/// `a * b + c`, fused if the target processor supports it: otherwise a fused one would be a call.
#[inline(always)]
fn fma(a: f64, b: f64, c: f64) -> f64 {
    if cfg!(target_feature = "fma") { a.mul_add(b, c) } else { a * b + c }
}
