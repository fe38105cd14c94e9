//! Cases of servo joints with records of only the target and the servo's own position. They are hobby servos,
//! with a motor on a bounded voltage behind a proportional loop, and industrial drives with a fast sampled
//! loop.
//!
//! The joint ([`axis`](super::axis)) is shared with the wild cases. The loop ([`firmware`]) is written by
//! hand. Neither the simulator nor its library of effects makes the data.

pub(super) mod conditions;
mod draw;
mod files;
mod firmware;
mod hidden;
mod record;

use std::io;
use std::path::Path;

use super::cases::Case;
use super::make::write_all;
use super::noise::Random;

pub use conditions::ServoConditions;

/// Writes `cases` cases of servo joints: datasets, experiments held back, and the sealed truth. `is_known`
/// says whether the library has a kind; other kinds are hidden as effects outside the library.
///
/// # Errors
/// If a file cannot be written.
pub fn make_servo(
    folder: &Path,
    cases: usize,
    seed: u64,
    is_known: &(dyn Fn(&str) -> bool + Sync),
    progress: &(dyn Fn(usize) + Sync),
) -> io::Result<()> {
    write_all(folder, cases, progress, |index| write_case(folder, index, seed, is_known))
}

fn write_case(folder: &Path, index: usize, seed: u64, is_known: &dyn Fn(&str) -> bool) -> io::Result<Case> {
    let mut random = Random::new(seed.wrapping_mul(15_485_863).wrapping_add(index as u64));
    let drawn = draw::draw(index, &mut random, is_known);
    files::write(folder, &drawn, &mut random)?;
    Ok(drawn.case)
}
