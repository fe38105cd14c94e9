//! Sign of a command against the motion that it drives, from its work. Friction, noise and slow motion hide
//! the sign of an acceleration, but not that of the work.

use feeler_plant::assembly::GROUND_NODE;
use feeler_plant::description::Quantity;

use super::consistency::{Body, Odd};
use super::data::Record;
use super::fault::FaultKind;
use super::units::SIGN;

/// Number of stretches of a record over which the command is averaged: far fewer than rows, so that noise and
/// encoder steps hardly move, and some in every swing.
const STRETCHES: usize = 400;
/// Work over closed paths, as a share of the work without signs, below which a machine would give energy. The
/// speed at both ends accounts for less.
const BACKWARD: f64 = -0.2;

impl Body<'_> {
    /// Reports a position that moves against its command: over all experiments together, or in some of them
    /// alone. A machine only takes energy over a closed path. A drive at its limit may seem to give a little
    /// back in one of them.
    pub(super) fn work(&self, odd: &mut Vec<Odd>) {
        let is_moved = self.assembly.drives.iter().any(|drive| drive.imposed.is_some())
            || self.assembly.contacts.iter().any(|contact| contact.profile.is_some());
        let is_named = |odd: &Odd| matches!(odd.kind, FaultKind::Units { factor, .. } if factor < 0.0);
        if is_moved || odd.iter().any(is_named) {
            return;
        }
        for (c, channel) in self.dataset.channels.iter().enumerate() {
            let Some((node, to, Quantity::Position)) = self.assembly.node_read(channel.source) else {
                continue;
            };
            if self.groups[to] != self.groups[GROUND_NODE] {
                continue;
            }
            let of = |(r, record): (usize, &Record)| {
                let (command, other, _) = self.drive_of(record, self.groups[node])?;
                let positions = self.without_gain(channel, record.series[c].clone());
                Some((r, other, closed_work(command, &positions)?))
            };
            let works: Vec<_> = self.dataset.records.iter().enumerate().filter_map(of).collect();
            let [work, plain] = [0, 1].map(|i| works.iter().map(|(.., both)| both[i]).sum::<f64>());
            // If the others clearly take energy, one experiment that clearly gives some is turned by itself.
            let most = if work < BACKWARD * plain {
                0.0
            } else if works.iter().any(|(.., [work, plain])| *work > -BACKWARD * plain) {
                BACKWARD
            } else {
                continue;
            };
            let backward = works.into_iter().filter(|(.., [work, plain])| *work < most * plain);
            let turned = backward.map(|(record, other, _)| {
                let kind = FaultKind::Units { other, factor: -1.0, what: SIGN, experiments: 1 };
                Odd { record, column: channel.column.clone(), kind }
            });
            let turned: Vec<Odd> = turned.collect();
            if !turned.is_empty() {
                odd.extend(turned);
                return;
            }
        }
    }
}

/// Work of a command over the longest closed path from the first position, and the same without signs.
/// `None` if the path closes in the first half of the record only.
fn closed_work(command: &[f64], positions: &[f64]) -> Option<[f64; 2]> {
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
    Some([works.iter().sum(), works.iter().map(|work| work.abs()).sum()])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A force that moves a mass of one against damping and dry friction, four swings long, with noise as
    /// large as the friction.
    fn forced(damping: f64, friction: f64, sign: f64) -> f64 {
        let wave = |k: usize| (std::f64::consts::TAU * k as f64 / 1000.0).sin_cos();
        let noise = |k: usize| 2.0 * friction * (((k * 7919) % 1009) as f64 / 1009.0 - 0.5);
        let command: Vec<f64> = (0..4200)
            .map(|k| {
                let (sine, cosine) = wave(k);
                -sine + damping * cosine + friction * cosine.signum() + noise(k)
            })
            .collect();
        let positions: Vec<f64> = (0..4200).map(|k| sign * (wave(k).0 * 500.0).round() / 500.0).collect();
        let [work, plain] = closed_work(&command, &positions).unwrap();
        work / plain
    }

    #[test]
    fn truth_only_a_reversed_sign_takes_energy_out_of_a_machine() {
        for (damping, friction) in [(0.3, 0.0), (0.1, 0.5), (1.0, 3.0)] {
            let [right, reversed] = [1.0, -1.0].map(|sign| forced(damping, friction, sign));
            assert!(right > -BACKWARD && reversed < BACKWARD, "{right} {reversed}");
        }
        // Without losses a closed path takes no work in either direction.
        let [right, reversed] = [1.0, -1.0].map(|sign| forced(0.0, 0.0, sign));
        assert!(right > BACKWARD && reversed > BACKWARD, "{right} {reversed}");
    }

    #[test]
    fn truth_a_path_that_does_not_close_says_nothing() {
        let lowered: Vec<f64> = (0..1000).map(|k| -0.001 * f64::from(k)).collect();
        assert_eq!(closed_work(&[5.0; 1000], &lowered), None);
    }
}
