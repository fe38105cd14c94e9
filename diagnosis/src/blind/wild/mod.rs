//! Cases with the conditions of real records. Motion is slow, friction takes most of the command, and the
//! command is measured with noise. Encoders are coarse, clocks jitter, and rows are lost.
//!
//! The axis ([`axis`](super::axis)) is shared with the servo cases. Neither the simulator nor its library of
//! effects makes the data.

pub(super) mod conditions;
mod draw;
mod files;
mod hidden;
mod motion;
mod record;

use std::io;
use std::path::Path;

use super::cases::Case;
use super::make::write_all;
use super::noise::Random;

pub use conditions::Conditions;

/// Writes `cases` cases with the conditions of real records: datasets, experiments held back, and the sealed
/// truth. `is_known` says whether the library has a kind; other kinds are hidden as effects outside the
/// library.
///
/// # Errors
/// If a file cannot be written.
pub fn make_wild(
    folder: &Path,
    cases: usize,
    seed: u64,
    is_known: &(dyn Fn(&str) -> bool + Sync),
    progress: &(dyn Fn(usize) + Sync),
) -> io::Result<()> {
    write_all(folder, cases, progress, |index| write_case(folder, index, seed, is_known))
}

fn write_case(folder: &Path, index: usize, seed: u64, is_known: &dyn Fn(&str) -> bool) -> io::Result<Case> {
    let mut random = Random::new(seed.wrapping_mul(7_368_787).wrapping_add(index as u64));
    let drawn = draw::draw(index, &mut random, is_known);
    files::write(folder, &drawn, &mut random)?;
    Ok(drawn.case)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_seed_makes_the_same_files_and_another_makes_others() {
        let [a, b, c] = [(7, 11), (7, 11), (8, 11)].map(|(seed, index)| {
            let folder = tempfile::tempdir().unwrap();
            let case = write_case(folder.path(), index, seed, &|_| false).unwrap();
            let read = |file: &str| std::fs::read_to_string(folder.path().join(file)).unwrap();
            let dataset = read("cases/case-011/dataset.toml");
            let held = read("held-back/case-011/waves.csv");
            (case, dataset, read("cases/case-011/machine.toml"), held)
        });
        assert_eq!(a, b);
        assert_ne!(a.3, c.3);
    }
}
