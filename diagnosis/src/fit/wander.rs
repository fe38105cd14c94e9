//! Deviation of an anchored prediction by the noise of a measured command.

use feeler_plant::assembly::assemble;
use feeler_plant::description::ActuatorKind;

use crate::chance::Chance;
use crate::dataset::{Dataset, Record, scatter};

/// Noise is as large in every other row as in all of them; what a command really does is not. A smooth
/// command has more scatter in every other row, and one that holds its values has less. Beyond this ratio,
/// either way, the scatter of a command is not noise.
const AS_LARGE: f64 = 1.25;
/// Scatter of more than this share of a command (root mean square) belongs to the command.
const MOST_NOISE: f64 = 0.3;

/// One sigma of white noise in a command; zero where its scatter is its own.
pub(crate) fn command_noise(command: &[f64]) -> f64 {
    let every_other: Vec<f64> = command.iter().step_by(2).copied().collect();
    let [all, other] = [command, &every_other].map(scatter);
    let is_noise = other < AS_LARGE * all && all < AS_LARGE * other && all < MOST_NOISE * rms(command);
    if is_noise { all } else { 0.0 }
}

fn rms(series: &[f64]) -> f64 {
    (series.iter().map(|u| u * u).sum::<f64>() / series.len().max(1) as f64).sqrt()
}

/// One sigma of white noise in the first command of a record, if that is a force.
pub(crate) fn force_noise(dataset: &Dataset, record: usize) -> f64 {
    pushed(dataset, record).map_or(0.0, |(_, command)| command_noise(command))
}

/// The record with as much noise again on its first command. `None` if that has no noise.
pub(crate) fn with_noise_again(dataset: &Dataset, record: usize) -> Option<Record> {
    let sigma = Some(force_noise(dataset, record)).filter(|sigma| *sigma > 0.0)?;
    let mut again = dataset.records[record].clone();
    let mut chance = Chance::default();
    again.commands[0].iter_mut().for_each(|u| *u += sigma * chance.deviate());
    Some(again)
}

/// Mass that the first drive pushes and its command in a record, where the command is a force.
fn pushed(dataset: &Dataset, record: usize) -> Option<(f64, &[f64])> {
    let drive = dataset.drives.first()?.drive;
    let command = dataset.records[record].commands.first()?;
    let is_force = matches!(dataset.machine.actuators[drive].kind, ActuatorKind::Force { .. })
        && !dataset.is_looped(drive);
    let assembly = assemble(&dataset.machine).ok().filter(|_| is_force)?;
    let mass = assembly.rigid_mass_kg(assembly.drives[drive].on);
    (mass.is_finite() && mass > 0.0).then_some((mass, command))
}

/// One sigma of an anchored position by the noise of the first command. The position follows as an oscillator
/// of natural frequency `omega` (rad/s) and a damping ratio of the root of a half. It is driven by an
/// acceleration whose values last a row each, and has the variance `density / (2 sqrt(2) omega^3)`.
pub(crate) fn wander(dataset: &Dataset, record: usize, omega: f64) -> f64 {
    let Some((mass, command)) = pushed(dataset, record).filter(|_| omega > 0.0) else { return 0.0 };
    let density = (command_noise(command) / mass).powi(2) * dataset.records[record].spacing_s;
    (density / (2.0 * std::f64::consts::SQRT_2 * omega.powi(3))).sqrt()
}

/// Root mean square of the acceleration that the first command would make by itself. If friction takes most
/// of it, laws of friction are off by a share of this acceleration and not of the motion's own.
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
        assert!((command_noise(&noisy) / 0.02 - 1.0).abs() < 0.1);
        let held: Vec<f64> = (0..4000).map(|k| (0.9 * f64::from(k / 2)).sin()).collect();
        assert!(command_noise(&held) == 0.0, "{}", command_noise(&held));
        let clean: Vec<f64> = (0..4000).map(|k| (0.3 * f64::from(k)).sin()).collect();
        assert!(command_noise(&clean) < 1e-3);
        // A command may be as rough as noise.
        let asked: Vec<f64> = (0..4000).map(|_| chance.deviate()).collect();
        assert!(command_noise(&asked) == 0.0);
    }
}
