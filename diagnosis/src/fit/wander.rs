//! Deviation of an anchored prediction due to the noise of a measured command.

use feeler_plant::assembly::assemble;

use crate::chance::Chance;
use crate::dataset::{Dataset, Record, noise_of_command, rms};

/// Standard deviation of white noise in a command of the first drive: as stated, or else from its scatter.
pub(crate) fn command_noise(dataset: &Dataset, command: &[f64]) -> f64 {
    let stated = dataset.drives.first().and_then(|driven| driven.noise);
    stated.unwrap_or_else(|| noise_of_command(command))
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
    let assembly = assemble(&dataset.machine).ok().filter(|_| dataset.is_forced(drive))?;
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
