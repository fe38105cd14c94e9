//! Delays of forces and motions behind their commands: different clocks.

use std::f64::consts::FRAC_PI_2;

use feeler_plant::assembly::Source;
use feeler_plant::description::{Engagement, Quantity};

use super::compare::{Comparison, SURE, compare, smoothed};
use super::consistency::{Body, NEAR_FORCE, Odd, SAME_PUSH, STATED_ROWS, Stick, accused};
use super::data::{Channel, Record};
use super::fault::{FaultKind, Yardstick};

/// Time over which the rise of a driving force is measured, s.
const RISE_S: f64 = 10e-3;
/// Smallest shift of a force or command between experiments that is reported, s. Delays and lags of a drive
/// shift it by some milliseconds.
const STATED_OF_FORCE_S: f64 = 6e-3;

/// Delay of a motion or a force behind its command.
pub(super) struct Late {
    record: usize,
    channel: usize,
    /// Column of the command.
    command: String,
    comparison: Comparison,
}

impl Late {
    fn rows(&self) -> f64 {
        self.comparison.late_rows
    }
}

/// Rise of a series within [`RISE_S`].
fn rises(series: &[f64], record: &Record) -> Vec<f64> {
    let span = ((RISE_S / record.spacing_s).round() as usize).max(1);
    (span..series.len()).map(|k| series[k] - series[k - span]).collect()
}

impl Body<'_> {
    /// Reports forces in wrong units, and returns the delay of each force in rows.
    pub(super) fn forces(
        &self,
        r: usize,
        sticks: &[Stick],
        references: &[usize],
        odd: &mut Vec<Odd>,
    ) -> Vec<Late> {
        let record = &self.dataset.records[r];
        if record.engagement.is_none_or(|engagement| engagement == Engagement::Free) {
            return Vec::new();
        }
        let mut late = Vec::new();
        for (c, channel) in self.dataset.channels.iter().enumerate() {
            let Some(group) = self.pushed_by(channel) else { continue };
            let Some(&reference) = references.iter().find(|&&i| self.groups[sticks[i].node] == group) else {
                continue;
            };
            let Some((command, other, mass)) = self.drive_of(record, group) else { continue };
            let is_constant = record.series[c].iter().all(|x| x.to_bits() == record.series[c][0].to_bits());
            if is_constant {
                continue;
            }
            let span = Self::span(record);
            let pushed: Vec<f64> = smoothed(command, span)
                .iter()
                .zip(&sticks[reference].values)
                .map(|(u, a)| u - mass * a)
                .collect();
            let felt = self.without_gain(channel, smoothed(&record.series[c], span));
            let Some(comparison) = compare(&pushed, &felt, Self::most(record), SAME_PUSH) else { continue };
            let pair =
                [self.reading(&channel.column, Quantity::Force), self.reading(&other, Quantity::Command)];
            odd.extend(accused(r, pair, comparison.factor, NEAR_FORCE, true));
            // Constant stretches hardly determine a delay, but rises do.
            let [pushed, felt] = [pushed, felt].map(|series| rises(&series, record));
            let Some(comparison) = compare(&pushed, &felt, Self::most(record), SAME_PUSH) else { continue };
            late.push(Late { record: r, channel: c, command: other, comparison });
        }
        late
    }

    /// Delay of each motion behind its command, in rows.
    pub(super) fn commands(&self, r: usize, sticks: &[Stick], references: &[usize]) -> Vec<Late> {
        let record = &self.dataset.records[r];
        let of = |&i: &usize| {
            let (column, makes) = self.driven_by(record, self.groups[sticks[i].node])?;
            let [made, moved] = [&makes, &sticks[i].values].map(|series| rises(series, record));
            let comparison = compare(&made, &moved, Self::most(record), SAME_PUSH)?;
            Some(Late { record: r, channel: sticks[i].channel, command: column, comparison })
        };
        references.iter().filter_map(of).collect()
    }

    /// Comparisons with a well-determined delay.
    fn known<'l>(&self, late: impl Iterator<Item = &'l Late>) -> Vec<&'l Late> {
        late.filter(|late| {
            SURE * late.comparison.late_sd * self.dataset.records[late.record].spacing_s < STATED_OF_FORCE_S
        })
        .collect()
    }

    /// Delay of `late` beyond that of `best`, s, if it is large enough to be reported.
    fn behind_s(&self, late: &Late, best: &Late) -> Option<f64> {
        let late_s = |late: &Late| late.rows() * self.dataset.records[late.record].spacing_s;
        let behind_s = late_s(late) - late_s(best);
        (behind_s.abs() >= STATED_OF_FORCE_S).then_some(behind_s)
    }

    /// Reports clocks of commands. If a motion is late behind its command in every experiment, the machine
    /// may delay it. If it is late in some experiments only, the command's clock is wrong.
    pub(super) fn command_clocks(&self, motions: &[Late], odd: &mut Vec<Odd>) {
        let known = self.known(motions.iter());
        let Some(best) = known.iter().min_by(|a, b| a.rows().abs().total_cmp(&b.rows().abs())) else {
            return;
        };
        for motion in &known {
            // Friction and damping also shift a motion against its command, but by less than a quarter wave.
            let is_turned = (motion.rows() * motion.comparison.omega).abs() > FRAC_PI_2;
            if let Some(late_s) = self.behind_s(motion, best).filter(|_| is_turned) {
                let against = Yardstick::Itself { file: self.dataset.records[best.record].name.clone() };
                let kind = FaultKind::ClockOffset { against, late_s: -late_s, experiments: 1 };
                odd.push(Odd { record: motion.record, column: motion.command.clone(), kind });
            }
        }
    }

    /// The group of bodies that presses on the contact of a force channel.
    fn pushed_by(&self, channel: &Channel) -> Option<usize> {
        let source = match channel.source {
            Source::Sensor(i) => self.assembly.sensors.get(i)?.source,
            source => source,
        };
        match source {
            Source::Contact(contact, Quantity::Force | Quantity::SpringForce) => {
                Some(self.groups[self.assembly.contacts.get(contact)?.a])
            }
            _ => None,
        }
    }

    /// Reports clocks of forces. If a force is late in every experiment, the machine may delay it. If it is
    /// late in some only, a clock is wrong. A force ahead of its drive is not a reference: there the command
    /// is late.
    pub(super) fn force_clocks(&self, forces: &[Late], odd: &mut Vec<Odd>) {
        for c in 0..self.dataset.channels.len() {
            let known = self.known(forces.iter().filter(|force| force.channel == c));
            let causal = known.iter().filter(|force| force.rows() > -STATED_ROWS);
            let Some(best) = causal.min_by(|a, b| a.rows().abs().total_cmp(&b.rows().abs())) else {
                continue;
            };
            for force in &known {
                let Some(behind_s) = self.behind_s(force, best) else { continue };
                let (column, file) =
                    (self.dataset.channels[c].column.clone(), self.dataset.records[best.record].name.clone());
                let (column, against, late_s) = if force.rows() > -STATED_ROWS {
                    (column, Yardstick::Itself { file }, behind_s)
                } else {
                    (force.command.clone(), Yardstick::ColumnAsIn { other: column, file }, -behind_s)
                };
                odd.push(Odd {
                    record: force.record,
                    column,
                    kind: FaultKind::ClockOffset { against, late_s, experiments: 1 },
                });
            }
        }
    }
}
