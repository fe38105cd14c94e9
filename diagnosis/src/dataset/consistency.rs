//! Consistency of columns that measure one motion: mixed-up units and different clocks.
//!
//! Bodies believed rigid move as one far below any resonance, so every encoder and accelerometer on them
//! gives the same acceleration. In free motion the command over the mass gives it too, if roughly. In
//! contact, the command less the inertial force is the contact force. In every experiment the reference is
//! the column that agrees with most others. A column that departs from it by a factor between units, or by a
//! shift in time, is named.

use std::f64::consts::FRAC_PI_2;

use feeler_plant::assembly::{Assembly, GROUND_NODE, Source, assemble};
use feeler_plant::description::{Engagement, Machine, Quantity};

use super::compare::{Comparison, SURE, compare, second_difference, smoothed};
use super::data::{Channel, Dataset, Record};
use super::fault::{Fault, FaultKind, Yardstick};
use super::units::mixed_up;

/// Span of the second difference, s: long enough for an encoder's noise, short enough to follow the motion.
const SPAN_S: f64 = 4e-3;
/// Time within which rises of pushing forces are measured, s.
const RISE_S: f64 = 10e-3;
/// Largest shift of the search, s.
const MOST_SHIFT_S: f64 = 0.05;
/// Smallest shift in rows that is reported between columns of one body.
const STATED_ROWS: f64 = 1.0;
/// The same between bodies with some flexibility in between.
const STATED_ROWS_ACROSS: f64 = 3.0;
/// Smallest shift of a force or a command between experiments that is reported, s: delays and lags of a drive
/// shift it by some milliseconds.
const STATED_OF_FORCE_S: f64 = 6e-3;
/// Smallest correlation of two readings of the same motion, and of a push with its motion or force.
const SAME_MOTION: f64 = 0.85;
const SAME_PUSH: f64 = 0.7;
/// Smallest correlation at which a shift between different bodies is accepted: a flexible joint also changes
/// the shape of a motion.
const SAME_SHAPE: f64 = 0.95;
/// Relative tolerance of a factor between units, for readings of one motion.
const NEAR: f64 = 0.15;
/// The same with a mass and friction in between.
const NEAR_FORCE: f64 = 0.3;
/// Largest factor between a motion and the command over the believed mass.
const PLAUSIBLE: f64 = 3.0;

/// The acceleration of a group of bodies from one column.
struct Stick {
    channel: usize,
    node: usize,
    quantity: Quantity,
    values: Vec<f64>,
}

/// A column that departs in one experiment.
struct Odd {
    record: usize,
    column: String,
    kind: FaultKind,
}

/// Delay of a motion or a force behind its command.
struct Late {
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

/// The machine, reduced to groups of bodies with one motion.
struct Body<'a> {
    dataset: &'a Dataset,
    assembly: Assembly,
    /// For each node, the lowest node rigidly joined to it.
    groups: Vec<usize>,
}

/// Reports factors between units and shifts of time, each with the first experiment that shows it and their
/// number.
pub(super) fn check(dataset: &Dataset) -> Vec<Fault> {
    let Ok(assembly) = assemble(&dataset.machine) else { return Vec::new() };
    let groups = groups(&assembly);
    let body = Body { dataset, assembly, groups };
    let sticks: Vec<Vec<Stick>> = dataset.records.iter().map(|record| body.sticks(record)).collect();
    // Number of agreements of a column with another one, over all experiments: it decides if one experiment
    // does not.
    let mut agreements = vec![0_usize; dataset.channels.len()];
    let pairs: Vec<Vec<(usize, usize, Comparison)>> =
        (0..dataset.records.len()).map(|r| body.pairs(r, &sticks[r])).collect();
    for (sticks, pairs) in sticks.iter().zip(&pairs) {
        for (i, j, comparison) in pairs {
            if agrees(comparison.factor) {
                agreements[sticks[*i].channel] += 1;
                agreements[sticks[*j].channel] += 1;
            }
        }
    }
    let mut odd = Vec::new();
    let mut forces = Vec::new();
    let mut commands = Vec::new();
    for r in 0..dataset.records.len() {
        let references = body.motion(r, &sticks[r], &pairs[r], &agreements, &mut odd);
        commands.extend(body.commands(r, &sticks[r], &references));
        forces.extend(body.forces(r, &sticks[r], &references, &mut odd));
    }
    body.force_clocks(&forces, &mut odd);
    body.command_clocks(&commands, &mut odd);
    merge(dataset, odd)
}

fn agrees(factor: f64) -> bool {
    factor > 0.0 && factor.ln().abs() < 2.0 * NEAR.ln_1p()
}

/// One fault per column and cause, with the first experiment that shows it.
fn merge(dataset: &Dataset, odd: Vec<Odd>) -> Vec<Fault> {
    let alike = |a: &FaultKind, b: &FaultKind| match (a, b) {
        (FaultKind::Units { what: a, other: x, .. }, FaultKind::Units { what: b, other: y, .. }) => {
            a == b && x == y
        }
        (
            FaultKind::ClockOffset { late_s: a, against: x, .. },
            FaultKind::ClockOffset { late_s: b, against: y, .. },
        ) => x == y && (a - b).abs() < 2.0 * dataset.records[0].spacing_s,
        _ => false,
    };
    let mut faults: Vec<Fault> = Vec::new();
    for Odd { record, column, kind } in odd {
        let known = faults
            .iter_mut()
            .find(|fault| fault.column.as_ref() == Some(&column) && alike(&fault.kind, &kind));
        match known.map(|fault| &mut fault.kind) {
            Some(FaultKind::Units { experiments, .. } | FaultKind::ClockOffset { experiments, .. }) => {
                *experiments += 1;
            }
            _ => faults.push(Fault {
                file: dataset.records[record].name.clone(),
                column: Some(column),
                row: None,
                kind,
            }),
        }
    }
    faults
}

/// For each node, the lowest node rigidly joined to it.
fn groups(assembly: &Assembly) -> Vec<usize> {
    let mut groups: Vec<usize> = (0..assembly.nodes.len()).collect();
    for _ in 0..assembly.links.len() {
        for link in assembly.links.iter().filter(|link| link.rigid) {
            let lower = groups[link.a].min(groups[link.b]);
            groups[link.a] = lower;
            groups[link.b] = lower;
        }
    }
    groups
}

/// The body that a channel reads.
fn node_of(machine: &Machine, assembly: &Assembly, channel: &Channel) -> Option<usize> {
    let source = match channel.source {
        Source::Sensor(i) => assembly.sensors.get(i)?.source,
        source => source,
    };
    match source {
        Source::Node(node, _) if node != GROUND_NODE && node <= machine.bodies.len() => Some(node),
        _ => None,
    }
}

/// Rise of a series within [`RISE_S`].
fn rises(series: &[f64], record: &Record) -> Vec<f64> {
    let span = ((RISE_S / record.spacing_s).round() as usize).max(1);
    (span..series.len()).map(|k| series[k] - series[k - span]).collect()
}

impl Body<'_> {
    fn span(record: &Record) -> usize {
        ((SPAN_S / record.spacing_s).round() as usize).max(1)
    }

    fn most(record: &Record) -> usize {
        (MOST_SHIFT_S / record.spacing_s) as usize
    }

    /// Every column of motion as an acceleration, with equal averaging.
    fn sticks(&self, record: &Record) -> Vec<Stick> {
        let span = Self::span(record);
        if record.len() < 4 * (span + Self::most(record)) {
            return Vec::new();
        }
        let of = |(channel, (described, series)): (usize, (&Channel, &Vec<f64>))| {
            let node = node_of(&self.dataset.machine, &self.assembly, described)?;
            let quantity = described.quantity(&self.dataset.machine);
            let values = match quantity {
                Quantity::Position => second_difference(series, span, record.spacing_s),
                Quantity::Acceleration => smoothed(series, span),
                _ => return None,
            };
            Some(Stick { channel, node, quantity, values })
        };
        self.dataset.channels.iter().zip(&record.series).enumerate().filter_map(of).collect()
    }

    /// Pairs of one group with the same motion.
    fn pairs(&self, r: usize, sticks: &[Stick]) -> Vec<(usize, usize, Comparison)> {
        let most = Self::most(&self.dataset.records[r]);
        let mut pairs = Vec::new();
        for i in 0..sticks.len() {
            for j in 0..i {
                if self.groups[sticks[i].node] == self.groups[sticks[j].node]
                    && let Some(comparison) = compare(&sticks[j].values, &sticks[i].values, most, SAME_MOTION)
                {
                    pairs.push((i, j, comparison));
                }
            }
        }
        pairs
    }

    /// Names the columns of motion that depart, and returns the reference of every group.
    fn motion(
        &self,
        r: usize,
        sticks: &[Stick],
        pairs: &[(usize, usize, Comparison)],
        agreements: &[usize],
        odd: &mut Vec<Odd>,
    ) -> Vec<usize> {
        let record = &self.dataset.records[r];
        let name = |stick: usize| self.dataset.channels[sticks[stick].channel].column.clone();
        let mut done: Vec<usize> = sticks.iter().map(|stick| self.groups[stick.node]).collect();
        done.sort_unstable();
        done.dedup();
        let mut references = Vec::new();
        for group in done {
            let members: Vec<usize> =
                (0..sticks.len()).filter(|&i| self.groups[sticks[i].node] == group).collect();
            let between = |i: usize, j: usize| {
                pairs.iter().find_map(|(a, b, comparison)| match (*a == i && *b == j, *a == j && *b == i) {
                    (true, _) => Some(*comparison),
                    (_, true) => Some(comparison.turned()),
                    _ => None,
                })
            };
            let driven = self.driven_by(record, group);
            let of_command = |i: usize| {
                driven
                    .as_ref()
                    .and_then(|(_, makes)| compare(makes, &sticks[i].values, Self::most(record), SAME_PUSH))
            };
            let plausible =
                |i: usize| of_command(i).is_some_and(|c| (1.0 / PLAUSIBLE..PLAUSIBLE).contains(&c.factor));
            let count = |i: usize, holds: &dyn Fn(Comparison) -> bool| {
                members.iter().filter(|&&j| j != i && between(i, j).is_some_and(holds)).count()
            };
            let is_position = |i: usize| sticks[i].quantity == Quantity::Position;
            let by_factor = |i: usize| {
                (count(i, &|c| agrees(c.factor)), plausible(i), agreements[sticks[i].channel], is_position(i))
            };
            let Some(&reference) = members.iter().max_by_key(|&&i| by_factor(i)) else { continue };
            for &i in members.iter().filter(|&&i| i != reference) {
                let Some(comparison) = between(i, reference) else { continue };
                if let Some(what) = mixed_up(comparison.factor, sticks[i].quantity, NEAR) {
                    let kind = FaultKind::Units {
                        other: name(reference),
                        factor: comparison.factor,
                        what,
                        experiments: 1,
                    };
                    odd.push(Odd { record: r, column: name(i), kind });
                }
            }
            // A clock is judged by the columns of its own body first: between bodies a joint may be flexible.
            let stated = |i: usize, j: usize, c: &Comparison| {
                let rows = if sticks[i].node == sticks[j].node { STATED_ROWS } else { STATED_ROWS_ACROSS };
                c.is_off_by(rows) && (sticks[i].node == sticks[j].node || c.correlation > SAME_SHAPE)
            };
            let in_time = |i: usize| {
                members
                    .iter()
                    .filter(|&&j| j != i && between(i, j).is_some_and(|c| !stated(i, j, &c)))
                    .count()
            };
            let Some(&clock) = members.iter().max_by_key(|&&i| (in_time(i), is_position(i))) else {
                continue;
            };
            // A comparison with this motion needs a reference that is correct in size and in time.
            references.push(if between(clock, reference).is_some_and(|c| agrees(c.factor)) {
                clock
            } else {
                reference
            });
            for &i in members.iter().filter(|&&i| i != clock) {
                if let Some(comparison) = between(i, clock).filter(|c| stated(i, clock, c)) {
                    let late_s = comparison.late_rows * record.spacing_s;
                    let kind = FaultKind::ClockOffset {
                        against: Yardstick::Column(name(clock)),
                        late_s,
                        experiments: 1,
                    };
                    odd.push(Odd { record: r, column: name(i), kind });
                }
            }
            self.against_command(
                r,
                sticks,
                reference,
                members.len(),
                driven.as_ref().zip(of_command(reference)),
                odd,
            );
        }
        references
    }

    /// All columns of a motion against the command: if two agree the command is wrong, a single one is wrong
    /// itself.
    fn against_command(
        &self,
        r: usize,
        sticks: &[Stick],
        reference: usize,
        members: usize,
        found: Option<(&(String, Vec<f64>), Comparison)>,
        odd: &mut Vec<Odd>,
    ) {
        let Some(((command, _), comparison)) = found else { return };
        let column = self.dataset.channels[sticks[reference].channel].column.clone();
        let (column, other, factor, quantity) = if members > 1 {
            (command.clone(), column, 1.0 / comparison.factor, Quantity::Command)
        } else {
            (column, command.clone(), comparison.factor, sticks[reference].quantity)
        };
        if let Some(what) = mixed_up(factor, quantity, NEAR_FORCE) {
            odd.push(Odd {
                record: r,
                column,
                kind: FaultKind::Units { other, factor, what, experiments: 1 },
            });
        }
    }

    /// The command of the drive that pushes a group, and the resulting acceleration of the group's mass in
    /// free motion.
    fn driven_by(&self, record: &Record, group: usize) -> Option<(String, Vec<f64>)> {
        let is_free = record
            .engagement
            .map_or(self.assembly.contacts.is_empty(), |engagement| engagement == Engagement::Free);
        let held = self.assembly.links.iter().any(|link| {
            !link.rigid
                && link.stiffness > 0.0
                && (self.groups[link.a] == group || self.groups[link.b] == group)
        });
        let (command, column, mass) = self.drive_of(record, group)?;
        let span = Self::span(record);
        (is_free && !held).then(|| (column, smoothed(command, span).into_iter().map(|u| u / mass).collect()))
    }

    /// The command of the only force drive of a group, its column, and the group's mass.
    fn drive_of<'r>(&self, record: &'r Record, group: usize) -> Option<(&'r Vec<f64>, String, f64)> {
        let mut drives = self.dataset.drives.iter().zip(&record.commands).filter(|((drive, _), _)| {
            let is_looped = self.dataset.is_looped(*drive);
            let drive = &self.assembly.drives[*drive];
            !is_looped && drive.commands_force() && self.groups[drive.on] == group
        });
        let ((drive, column), command) = drives.next().filter(|_| self.dataset.drives.len() == 1)?;
        let mass = self.assembly.rigid_mass_kg(self.assembly.drives[*drive].on);
        (mass.is_finite() && mass > 0.0).then(|| (command, column.clone(), mass))
    }

    /// Names forces in other units, and returns the delay of each in rows.
    fn forces(&self, r: usize, sticks: &[Stick], references: &[usize], odd: &mut Vec<Odd>) -> Vec<Late> {
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
            let felt = smoothed(&record.series[c], span);
            let Some(comparison) = compare(&pushed, &felt, Self::most(record), SAME_PUSH) else { continue };
            let column = channel.column.clone();
            if let Some(what) = mixed_up(comparison.factor, Quantity::Force, NEAR_FORCE) {
                let kind = FaultKind::Units {
                    other: other.clone(),
                    factor: comparison.factor,
                    what,
                    experiments: 1,
                };
                odd.push(Odd { record: r, column, kind });
            }
            // Constant parts hardly show time; rises do.
            let [pushed, felt] = [pushed, felt].map(|series| rises(&series, record));
            let Some(comparison) = compare(&pushed, &felt, Self::most(record), SAME_PUSH) else { continue };
            late.push(Late { record: r, channel: c, command: other, comparison });
        }
        late
    }

    /// Delay of each motion behind its command, in rows.
    fn commands(&self, r: usize, sticks: &[Stick], references: &[usize]) -> Vec<Late> {
        let record = &self.dataset.records[r];
        let of = |&i: &usize| {
            let (column, makes) = self.driven_by(record, self.groups[sticks[i].node])?;
            let [made, moved] = [&makes, &sticks[i].values].map(|series| rises(series, record));
            let comparison = compare(&made, &moved, Self::most(record), SAME_PUSH)?;
            Some(Late { record: r, channel: sticks[i].channel, command: column, comparison })
        };
        references.iter().filter_map(of).collect()
    }

    /// Those with a known delay.
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

    /// A motion that is delayed behind its command in every experiment may be an effect of the machine. In
    /// some experiments only, it is the command's clock.
    fn command_clocks(&self, motions: &[Late], odd: &mut Vec<Odd>) {
        let known = self.known(motions.iter());
        let Some(best) = known.iter().min_by(|a, b| a.rows().abs().total_cmp(&b.rows().abs())) else {
            return;
        };
        for motion in &known {
            // Friction and damping also shift a motion against its command, but by less than a quarter of its
            // wave.
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

    /// A force that is delayed in every experiment may be an effect of the machine; in some only, it is a
    /// clock. A force that precedes its push is not a reference: there the command is delayed.
    fn force_clocks(&self, forces: &[Late], odd: &mut Vec<Odd>) {
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
