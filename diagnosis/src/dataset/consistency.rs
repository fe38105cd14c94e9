//! Consistency of columns that measure the same motion: wrong units and different clocks.
//!
//! Rigidly joined bodies move together far below any resonance, so every encoder, tachometer and
//! accelerometer on them gives the same acceleration. In free motion the command divided by the mass gives it
//! roughly too. In contact, the command less the inertial force is the contact force. In every experiment the
//! reference is the column that agrees with most others. A column is reported if it differs from the
//! reference by a factor between units or a shift in time.

use std::cmp::Reverse;

use feeler_files::ColumnSpec;
use feeler_plant::assembly::{Assembly, GROUND_NODE, Link, Source, assemble};
use feeler_plant::description::{Axis, Engagement, Machine, Quantity};
use indexmap::IndexMap;

use super::compare::{Comparison, compare, difference, second_difference, smoothed};
use super::data::{Channel, Dataset, Record};
use super::fault::{Fault, FaultKind, Yardstick};
use super::units::{Reading, is_stated, wrong};

/// Span of the second difference, s: long enough to average an encoder's noise, short enough to follow the
/// motion.
const SPAN_S: f64 = 4e-3;
/// Largest shift of the search, s.
const MOST_SHIFT_S: f64 = 0.05;
/// Smallest shift in rows that is reported between columns of one body.
pub(super) const STATED_ROWS: f64 = 1.0;
/// Smallest shift in rows that is reported between bodies with a flexible joint in between.
const STATED_ROWS_ACROSS: f64 = 3.0;
/// Smallest correlation of two readings of the same motion, and of a driving force with its motion or contact
/// force.
pub(super) const SAME_MOTION: f64 = 0.85;
pub(super) const SAME_PUSH: f64 = 0.7;
/// Smallest correlation at which a shift between different bodies is accepted: a flexible joint also changes
/// the shape of a motion.
const SAME_SHAPE: f64 = 0.95;
/// Relative tolerance of a factor between units, for readings of one motion.
pub(super) const NEAR: f64 = 0.15;
/// Relative tolerance of a factor if a mass and friction lie between the columns.
pub(super) const NEAR_FORCE: f64 = 0.3;
/// Largest plausible ratio between a motion and the command over the believed mass.
const PLAUSIBLE: f64 = 3.0;

/// The acceleration of a group of bodies from one column.
pub(super) struct Stick {
    pub(super) channel: usize,
    pub(super) node: usize,
    pub(super) quantity: Quantity,
    pub(super) values: Vec<f64>,
}

/// A column that is inconsistent in one experiment.
pub(super) struct Odd {
    pub(super) record: usize,
    pub(super) column: String,
    pub(super) kind: FaultKind,
}

/// The command of a drive, its column, and the mass that it moves.
type Drive<'r> = (&'r Vec<f64>, String, f64);

/// The machine, reduced to groups of rigidly joined bodies.
pub(super) struct Body<'a> {
    pub(super) dataset: &'a Dataset,
    /// The columns as the dataset's file states them.
    columns: &'a IndexMap<String, ColumnSpec>,
    pub(super) assembly: Assembly,
    /// For each node, the lowest node rigidly joined to it.
    pub(super) groups: Vec<usize>,
}

/// Reports factors between units and shifts in time, each once: with the first experiment that shows it, and
/// the number of such experiments.
pub(super) fn check(dataset: &Dataset, columns: &IndexMap<String, ColumnSpec>) -> Vec<Fault> {
    let Ok(assembly) = assemble(&dataset.machine) else { return Vec::new() };
    let groups = groups(&assembly);
    let body = Body { dataset, columns, assembly, groups };
    let sticks: Vec<Vec<Stick>> = dataset.records.iter().map(|record| body.sticks(record)).collect();
    // Number of agreements of each column with others, over all experiments. It is used if a single
    // experiment does not show which column is wrong.
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
        body.targets(r, &mut odd);
    }
    body.force_clocks(&forces, &mut odd);
    body.command_clocks(&commands, &mut odd);
    body.work(&mut odd);
    body.effort(&mut odd);
    merge(dataset, odd)
}

/// The wrong one of two columns of the same motion, from the ratio of the first to the second.
pub(super) fn accused(
    record: usize,
    pair: [Reading<'_>; 2],
    factor: f64,
    near: f64,
    is_second_right: bool,
) -> Option<Odd> {
    let (is_second, what) = wrong(pair, factor, near, is_second_right)?;
    let [first, second] = pair;
    let (column, other, factor) =
        if is_second { (second, first, 1.0 / factor) } else { (first, second, factor) };
    let kind = FaultKind::Units { other: other.column.to_owned(), factor, what, experiments: 1 };
    Some(Odd { record, column: column.column.to_owned(), kind })
}

fn agrees(factor: f64) -> bool {
    factor > 0.0 && factor.ln().abs() < 2.0 * NEAR.ln_1p()
}

/// The comparison of column `i` with column `j`.
fn between(pairs: &[(usize, usize, Comparison)], i: usize, j: usize) -> Option<Comparison> {
    pairs.iter().find_map(|(a, b, comparison)| match (*a == i && *b == j, *a == j && *b == i) {
        (true, _) => Some(*comparison),
        (_, true) => Some(comparison.turned()),
        _ => None,
    })
}

/// One fault per column and cause, with the first experiment that shows it.
fn merge(dataset: &Dataset, odd: Vec<Odd>) -> Vec<Fault> {
    let alike = |a: &FaultKind, b: &FaultKind| match (a, b) {
        (FaultKind::Units { what: a, other: x, .. }, FaultKind::Units { what: b, other: y, .. }) => {
            a == b && x == y
        }
        (FaultKind::Beside { other: x, .. }, FaultKind::Beside { other: y, .. }) => x == y,
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
            Some(
                FaultKind::Units { experiments, .. }
                | FaultKind::Beside { experiments, .. }
                | FaultKind::ClockOffset { experiments, .. },
            ) => {
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
pub(super) fn node_of(machine: &Machine, assembly: &Assembly, channel: &Channel) -> Option<usize> {
    let source = match channel.source {
        Source::Sensor(i) => assembly.sensors.get(i)?.source,
        source => source,
    };
    match source {
        Source::Node(node, _) if node != GROUND_NODE && node <= machine.bodies.len() => Some(node),
        _ => None,
    }
}

impl Body<'_> {
    pub(super) fn span(record: &Record) -> usize {
        ((SPAN_S / record.spacing_s).round() as usize).max(1)
    }

    pub(super) fn most(record: &Record) -> usize {
        (MOST_SHIFT_S / record.spacing_s) as usize
    }

    /// Every motion column as an acceleration, averaged equally.
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
                Quantity::Velocity => difference(series, span, record.spacing_s),
                Quantity::Acceleration => smoothed(series, span),
                _ => return None,
            };
            Some(Stick { channel, node, quantity, values: self.without_gain(described, values) })
        };
        self.dataset.channels.iter().zip(&record.series).enumerate().filter_map(of).collect()
    }

    /// Readings of a channel divided by the believed gain of its sensor.
    pub(super) fn without_gain(&self, channel: &Channel, mut readings: Vec<f64>) -> Vec<f64> {
        let (gain, _) = channel.scale(&self.assembly);
        if gain != 0.0 {
            for reading in &mut readings {
                *reading /= gain;
            }
        }
        readings
    }

    /// Pairs of columns in one group with the same motion.
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

    /// Reports inconsistent motion columns, and returns the reference of every group.
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
            let between = |i: usize, j: usize| between(pairs, i, j);
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
            let stated =
                |i: usize| count(i, &|c| is_stated(c.factor, self.scale(self.column(&sticks[i])), NEAR));
            let agreeing = |i: usize| count(i, &|c| agrees(c.factor));
            let by_factor = |i: usize| {
                let known = (agreeing(i), plausible(i), Reverse(stated(i)));
                (known, agreements[sticks[i].channel], is_position(i))
            };
            let Some(&reference) = members.iter().max_by_key(|&&i| by_factor(i)) else { continue };
            for &i in members.iter().filter(|&&i| i != reference) {
                let Some(comparison) = between(i, reference) else { continue };
                let is_known = agreeing(reference) > 0 || plausible(reference) && !plausible(i);
                let pair = [i, reference].map(|i| self.reading(self.column(&sticks[i]), sticks[i].quantity));
                odd.extend(accused(r, pair, comparison.factor, NEAR, is_known));
            }
            // The filter of a velocity adds a delay, so velocities are not used for clocks. A clock is first
            // compared with columns of the same body, because a joint between bodies may be flexible.
            let timed: Vec<usize> =
                members.iter().copied().filter(|&i| sticks[i].quantity != Quantity::Velocity).collect();
            let late = |i: usize, j: usize, c: &Comparison| {
                let rows = if sticks[i].node == sticks[j].node { STATED_ROWS } else { STATED_ROWS_ACROSS };
                c.is_off_by(rows) && (sticks[i].node == sticks[j].node || c.correlation > SAME_SHAPE)
            };
            let in_time = |i: usize| {
                timed.iter().filter(|&&j| j != i && between(i, j).is_some_and(|c| !late(i, j, &c))).count()
            };
            let Some(&clock) = timed.iter().max_by_key(|&&i| (in_time(i), is_position(i))) else {
                continue;
            };
            // Forces and commands are compared with this reference, so it must be correct in size and in
            // time.
            references.push(if between(clock, reference).is_some_and(|c| agrees(c.factor)) {
                clock
            } else {
                reference
            });
            for &i in timed.iter().filter(|&&i| i != clock) {
                if let Some(comparison) = between(i, clock).filter(|c| late(i, clock, c)) {
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
                agreements[sticks[reference].channel] > 0,
                driven.as_ref().zip(of_command(reference)),
                odd,
            );
        }
        references
    }

    /// Compares the reference of a motion with the command. If another column agrees with the reference, the
    /// command is wrong; otherwise either may be wrong.
    fn against_command(
        &self,
        r: usize,
        sticks: &[Stick],
        reference: usize,
        is_agreed: bool,
        found: Option<(&(String, Vec<f64>), Comparison)>,
        odd: &mut Vec<Odd>,
    ) {
        let Some(((command, _), comparison)) = found else { return };
        let moved = self.reading(self.column(&sticks[reference]), sticks[reference].quantity);
        let pushed = self.reading(command, Quantity::Command);
        odd.extend(if is_agreed {
            accused(r, [pushed, moved], 1.0 / comparison.factor, NEAR_FORCE, true)
        } else {
            accused(r, [moved, pushed], comparison.factor, NEAR_FORCE, false)
        });
    }

    fn column(&self, stick: &Stick) -> &str {
        &self.dataset.channels[stick.channel].column
    }

    /// Factor that the file applies to a column's numbers.
    fn scale(&self, column: &str) -> f64 {
        self.columns.get(column).map_or(1.0, |column| column.scale)
    }

    pub(super) fn reading<'c>(&self, column: &'c str, quantity: Quantity) -> Reading<'c> {
        let is_turning = self.dataset.machine.axis == Axis::Rotational;
        Reading { column, quantity, scale: self.scale(column), is_turning }
    }

    /// The command of the drive that pushes a group, and the resulting acceleration of the group's mass in
    /// free motion. `None` if a spring holds the group.
    pub(super) fn driven_by(&self, record: &Record, group: usize) -> Option<(String, Vec<f64>)> {
        let ((command, column, mass), _) =
            self.free_drive_of(record, group).filter(|(_, stiffness)| *stiffness <= 0.0)?;
        let span = Self::span(record);
        Some((column, smoothed(command, span).into_iter().map(|u| u / mass).collect()))
    }

    /// [`Self::drive_of`] in free motion, with the stiffness that holds the group against the ground. `None`
    /// if a spring holds it against another body, or is not linear.
    pub(super) fn free_drive_of<'r>(&self, record: &'r Record, group: usize) -> Option<(Drive<'r>, f64)> {
        let is_free = record
            .engagement
            .map_or(self.assembly.contacts.is_empty(), |engagement| engagement == Engagement::Free);
        let ends = |link: &Link| [link.a, link.b].map(|node| self.groups[node]);
        let is_spring = |link: &&Link| {
            let is_elastic = !link.rigid && link.stiffness > 0.0;
            is_elastic && ends(link).contains(&group)
        };
        let held = |link: &Link| {
            let is_to_ground = ends(link).contains(&self.groups[GROUND_NODE]);
            let acts_partly = link.stop.is_some() || link.play > 0.0 || link.cubic != 0.0;
            (is_to_ground && !acts_partly).then_some(link.stiffness)
        };
        let stiffness = self.assembly.links.iter().filter(is_spring).map(held).sum::<Option<f64>>()?;
        is_free.then(|| Some((self.drive_of(record, group)?, stiffness))).flatten()
    }

    /// The only force drive of a group.
    pub(super) fn drive_of<'r>(&self, record: &'r Record, group: usize) -> Option<Drive<'r>> {
        let mut drives = self.dataset.drives.iter().zip(&record.commands).filter(|(driven, _)| {
            let is_looped = self.dataset.is_looped(driven.drive);
            let drive = &self.assembly.drives[driven.drive];
            !is_looped && drive.commands_force() && self.groups[drive.on] == group
        });
        let (driven, command) = drives.next().filter(|_| self.dataset.drives.len() == 1)?;
        let mass = self.assembly.rigid_mass_kg(self.assembly.drives[driven.drive].on);
        (mass.is_finite() && mass > 0.0).then(|| (command, driven.column.clone(), mass))
    }
}
