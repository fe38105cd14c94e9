//! Sign of a command against the motion that it drives, from its work. Friction, noise and slow motion hide
//! the sign of an acceleration, but not that of the work.

use feeler_plant::assembly::GROUND_NODE;
use feeler_plant::description::Quantity;

use super::consistency::{Body, Odd};
use super::fault::FaultKind;

/// Number of stretches of a record over which the command is averaged: far fewer than rows, so that noise and
/// encoder steps hardly move, and some in every swing.
const STRETCHES: usize = 400;
/// A command whose work over a closed path is below this share of the work without signs drives an energy out
/// of the machine that nothing has put in. The speed at both ends accounts for less.
const BACKWARD: f64 = -0.2;

impl Body<'_> {
    /// Reports a position that moves against its command. A machine only takes energy over a closed path.
    pub(super) fn work(&self, r: usize, odd: &mut Vec<Odd>) {
        let is_moved = self.assembly.drives.iter().any(|drive| drive.imposed.is_some())
            || self.assembly.contacts.iter().any(|contact| contact.profile.is_some());
        let is_named = odd.iter().any(|odd| {
            odd.record == r && matches!(odd.kind, FaultKind::Units { factor, .. } if factor < 0.0)
        });
        if is_moved || is_named {
            return;
        }
        let record = &self.dataset.records[r];
        for (channel, series) in self.dataset.channels.iter().zip(&record.series) {
            let Some((node, to, Quantity::Position)) = self.assembly.node_read(channel.source) else {
                continue;
            };
            if self.groups[to] != self.groups[GROUND_NODE] {
                continue;
            }
            let Some((command, other, _)) = self.drive_of(record, self.groups[node]) else { continue };
            let positions = self.without_gain(channel, series.clone());
            if closed_work(command, &positions).is_some_and(|share| share < BACKWARD) {
                let kind = FaultKind::Units { other, factor: -1.0, what: "-1 (a sign?)", experiments: 1 };
                odd.push(Odd { record: r, column: channel.column.clone(), kind });
                return;
            }
        }
    }
}

/// Work of a command over the longest closed path from the first position, as a share of the work without
/// signs. `None` if the path closes in the first half of the record only.
fn closed_work(command: &[f64], positions: &[f64]) -> Option<f64> {
    let rows = (positions.len() / STRETCHES).max(1);
    let ends: Vec<f64> = positions.iter().step_by(rows).copied().collect();
    let first = *ends.first()?;
    let is_back = |k: &usize| (ends[*k] - first) * (ends[*k - 1] - first) <= 0.0;
    let last = (1..ends.len()).rev().find(is_back).filter(|last| 2 * last >= ends.len())?;
    let works: Vec<f64> = command
        .chunks(rows)
        .zip(ends.windows(2))
        .take(last)
        .map(|(command, ends)| command.iter().sum::<f64>() / command.len() as f64 * (ends[1] - ends[0]))
        .collect();
    let plain: f64 = works.iter().map(|work| work.abs()).sum();
    (plain > 0.0).then(|| works.iter().sum::<f64>() / plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A force that moves a mass of one against damping and dry friction, four swings long, with noise as
    /// large as the friction.
    fn forced(damping: f64, friction: f64, sign: f64) -> Option<f64> {
        let wave = |k: usize| (std::f64::consts::TAU * k as f64 / 1000.0).sin_cos();
        let noise = |k: usize| 2.0 * friction * (((k * 7919) % 1009) as f64 / 1009.0 - 0.5);
        let command: Vec<f64> = (0..4200)
            .map(|k| {
                let (sine, cosine) = wave(k);
                -sine + damping * cosine + friction * cosine.signum() + noise(k)
            })
            .collect();
        let positions: Vec<f64> = (0..4200).map(|k| sign * (wave(k).0 * 500.0).round() / 500.0).collect();
        closed_work(&command, &positions)
    }

    #[test]
    fn truth_only_a_reversed_sign_takes_energy_out_of_a_machine() {
        for (damping, friction) in [(0.3, 0.0), (0.1, 0.5), (1.0, 3.0)] {
            let [right, reversed] = [1.0, -1.0].map(|sign| forced(damping, friction, sign).unwrap());
            assert!(right > -BACKWARD && reversed < BACKWARD, "{right} {reversed}");
        }
        // Without losses a closed path takes no work in either direction.
        let [right, reversed] = [1.0, -1.0].map(|sign| forced(0.0, 0.0, sign).unwrap());
        assert!(right > BACKWARD && reversed > BACKWARD, "{right} {reversed}");
    }

    #[test]
    fn truth_a_path_that_does_not_close_says_nothing() {
        let lowered: Vec<f64> = (0..1000).map(|k| -0.001 * f64::from(k)).collect();
        assert_eq!(closed_work(&[5.0; 1000], &lowered), None);
    }
}
