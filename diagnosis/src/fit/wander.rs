//! Deviation of an anchored prediction due to the noise of a measured command.

use feeler_plant::assembly::assemble;
use feeler_plant::description::ActuatorKind;

use crate::chance::Chance;
use crate::dataset::{Dataset, Record, command_scatter};

/// White noise has the same scatter in every other row as in all rows. A command that holds its values has
/// less scatter there: beyond this ratio it is not noise.
const HELD: f64 = 1.25;
/// A smooth command has far more scatter in every other row: up to 256 times more. Beyond this ratio the
/// scatter is not noise. Below it a smooth part is at most some percent of the noise.
const SMOOTH: f64 = 3.0;
/// Scatter of more than this share of a command (root mean square) belongs to the command.
const MOST_NOISE: f64 = 0.3;

/// Standard deviation of white noise in a command of the first drive: as stated, or else from its scatter.
pub(crate) fn command_noise(dataset: &Dataset, command: &[f64]) -> f64 {
    let stated = dataset.drives.first().and_then(|driven| driven.noise);
    stated.unwrap_or_else(|| scattered_noise(command))
}

/// Standard deviation of white noise in a command; zero if the scatter belongs to the command.
fn scattered_noise(command: &[f64]) -> f64 {
    let every_other: Vec<f64> = command.iter().step_by(2).copied().collect();
    let [all, other] = [command, &every_other].map(command_scatter);
    let is_noise = other < SMOOTH * all && all < HELD * other && all < MOST_NOISE * rms(command);
    if is_noise { all } else { 0.0 }
}

/// Root mean square of a series.
pub(super) fn rms(series: &[f64]) -> f64 {
    (series.iter().map(|u| u * u).sum::<f64>() / series.len().max(1) as f64).sqrt()
}

/// Standard deviation of white noise in the first command of a record, if that is a force.
pub(crate) fn force_noise(dataset: &Dataset, record: usize) -> f64 {
    pushed(dataset, record).map_or(0.0, |(_, command)| command_noise(dataset, command))
}

/// The record with noise of the same size added to its first command. `None` if the command has no noise.
pub(crate) fn with_noise_again(dataset: &Dataset, record: usize) -> Option<Record> {
    let sigma = Some(force_noise(dataset, record)).filter(|sigma| *sigma > 0.0)?;
    let mut again = dataset.records[record].clone();
    let mut chance = Chance::default();
    again.commands[0].iter_mut().for_each(|u| *u += sigma * chance.deviate());
    Some(again)
}

/// Mass that the first drive moves and its command in a record; `None` if the command is not a force.
fn pushed(dataset: &Dataset, record: usize) -> Option<(f64, &[f64])> {
    let drive = dataset.drives.first()?.drive;
    let command = dataset.records[record].commands.first()?;
    let is_force = matches!(dataset.machine.actuators[drive].kind, ActuatorKind::Force { .. })
        && !dataset.is_looped(drive);
    let assembly = assemble(&dataset.machine).ok().filter(|_| is_force)?;
    let mass = assembly.rigid_mass_kg(assembly.drives[drive].on);
    (mass.is_finite() && mass > 0.0).then_some((mass, command))
}

/// Standard deviation of an anchored position due to the noise of the first command. The observer is an
/// oscillator with natural frequency `omega` (rad/s) and damping ratio `1/sqrt(2)`. The noise drives it with
/// an acceleration that is constant over each row. The variance is `density / (2 sqrt(2) omega^3)`.
pub(crate) fn wander(dataset: &Dataset, record: usize, omega: f64) -> f64 {
    let Some((mass, command)) = pushed(dataset, record).filter(|_| omega > 0.0) else { return 0.0 };
    let density = (command_noise(dataset, command) / mass).powi(2) * dataset.records[record].spacing_s;
    (density / (2.0 * std::f64::consts::SQRT_2 * omega.powi(3))).sqrt()
}

/// Root mean square of the acceleration that the first command would cause without friction. If friction
/// takes most of the command, the error of a friction law is a share of this acceleration, not of the
/// measured one.
pub(crate) fn commanded_acceleration(dataset: &Dataset, record: usize) -> f64 {
    pushed(dataset, record).map_or(0.0, |(mass, command)| rms(command) / mass)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_noise_of_a_command_is_told_from_its_steps() {
        let mut chance = Chance::default();
        let noisy: Vec<f64> =
            (0..4000).map(|k| (0.01 * f64::from(k)).sin() + 0.02 * chance.deviate()).collect();
        // Neighbouring differences share rows, so that 4000 of them give the median to about four percent.
        assert!((scattered_noise(&noisy) / 0.02 - 1.0).abs() < 0.1);
        let held: Vec<f64> = (0..4000).map(|k| (0.9 * f64::from(k / 2)).sin()).collect();
        assert!(scattered_noise(&held) == 0.0, "{}", scattered_noise(&held));
        let clean: Vec<f64> = (0..4000).map(|k| (0.3 * f64::from(k)).sin()).collect();
        assert!(scattered_noise(&clean) < 1e-3);
        // A command may itself be as rough as noise.
        let asked: Vec<f64> = (0..4000).map(|_| chance.deviate()).collect();
        assert!(scattered_noise(&asked) == 0.0);
    }
}
