//! Tests whether a drive's command continues to move while its force rests.
//!
//! The command of an integrator moves on until a sticking guide breaks loose. Such a run only appears
//! settled.

use feeler_plant::assembly::Drive;

use crate::run::measure::settling::SETTLING_BAND;

/// Part of the settling band by which a command must move more than the force does.
const LEAST: f64 = 0.1;
/// A command that comes to rest moves in each piece by less than this share of the previous piece.
const GOES_ON: f64 = 0.5;

/// Whether the command alone determines the force of a drive. In a drive that warms, the command rises while
/// the force stays constant.
pub(in crate::run) fn commands_all(drive: &Drive) -> bool {
    drive.commands_force() && drive.warming.is_none()
}

/// The command of a drive as force, and what bounds it.
#[derive(Clone, Copy, Debug)]
pub(in crate::run) struct Command<'a> {
    /// The command row by row, N or in the unit of the command.
    values: &'a [f64],
    /// Newtons per unit of these values.
    gain: f64,
    /// Motion beyond this bound has no effect.
    bound: f64,
}

impl<'a> Command<'a> {
    /// The recorded signal of a drive: its command if [`commands_all`], else its force.
    pub(in crate::run) fn of(drive: &Drive, values: &'a [f64]) -> Self {
        let gain = if commands_all(drive) { drive.gain.abs() } else { 1.0 };
        Self { values, gain, bound: drive.limit + gain * drive.deadband }
    }

    /// A band about the motion of the command over the rows from `first` onwards, N.
    pub(in crate::run) fn band_n(&self, first: usize) -> f64 {
        SETTLING_BAND
            * self.values[first..].iter().fold(0.0_f64, |most, value| most.max((self.gain * value).abs()))
    }

    /// Whether the command winds up over the rows from `first` onwards, while `force_n` stays within a band
    /// of half-width `band_n`.
    pub(in crate::run) fn winds_up(&self, force_n: &[f64], first: usize, band_n: f64) -> bool {
        let moves = |of: &dyn Fn(usize) -> f64| {
            let rows = self.values.len() - first;
            let mean = |piece: usize| {
                let piece = first + piece * rows / 3..first + (piece + 1) * rows / 3;
                let count = piece.len().max(1) as f64;
                piece.map(of).sum::<f64>() / count
            };
            [mean(1) - mean(0), mean(2) - mean(1)]
        };
        let [before, last] = moves(&|row| (self.gain * self.values[row]).clamp(-self.bound, self.bound));
        let [_, answer] = moves(&|row| force_n[row]);
        before * last > 0.0
            && last.abs() > GOES_ON * before.abs()
            && last.abs() - answer.abs() > LEAST * band_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: usize = 3000;

    fn winds_up(command: impl Fn(f64) -> f64, bound: f64) -> bool {
        let values: Vec<f64> = (0..ROWS).map(|i| command(i as f64 / ROWS as f64)).collect();
        Command { values: &values, gain: 1.0, bound }.winds_up(&vec![20.0; values.len()], 0, 0.4)
    }

    #[test]
    fn truth_only_what_moves_on_within_its_bounds_winds() {
        assert!(winds_up(|t| 20.0 + t, f64::INFINITY));
        assert!(winds_up(|t| 20.0 - t, f64::INFINITY));
        assert!(!winds_up(|t| 20.0 + t, 19.0), "beyond the drive's limit");
        assert!(!winds_up(|t| 20.0 + (-5.0 * t).exp(), f64::INFINITY), "comes to rest");
        assert!(!winds_up(|t| 20.0 + 0.05 * t, f64::INFINITY), "less than the band resolves");
        let follows: Vec<f64> = (0..ROWS).map(|i| 20.0 + 0.3 * i as f64 / ROWS as f64).collect();
        assert!(
            !Command { values: &follows, gain: 1.0, bound: f64::INFINITY }.winds_up(&follows, 0, 0.4),
            "the force follows"
        );
    }
}
