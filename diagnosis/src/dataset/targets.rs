//! Compares targets of servos with the positions that follow them: wrong units and signs.

use feeler_plant::assembly::Source;
use feeler_plant::description::Quantity;

use super::compare::compare;
use super::consistency::{Body, NEAR_FORCE, Odd, SAME_MOTION, accused, node_of};
use super::data::{Channel, Driven};
use super::fault::FaultKind;
use super::units::{COUNTS, Reading};

/// Largest lag of a position behind its target in the search, s.
const MOST_LAG_S: f64 = 0.5;
/// Spacing of the compared rows, s: a servo hardly moves in a shorter time.
const STEP_S: f64 = 5e-3;
/// Largest ratio between a target and the position at which a servo holds it.
const UNLIKE: f64 = 5.0;

impl Body<'_> {
    /// Reports targets and positions of one motion in different units or with opposite signs.
    pub(super) fn targets(&self, r: usize, odd: &mut Vec<Odd>) {
        let record = &self.dataset.records[r];
        let stride = ((STEP_S / record.spacing_s).round() as usize).max(1);
        let lag = (MOST_LAG_S / (stride as f64 * record.spacing_s)) as usize;
        let most = lag.min(record.len() / stride / 4);
        for (driven, command) in self.dataset.drives.iter().zip(&record.commands) {
            let target = without_mean(command, stride);
            for (channel, series) in self.dataset.channels.iter().zip(&record.series) {
                if !self.is_followed_by(driven, channel) {
                    continue;
                }
                odd.extend(self.beside(r, driven, channel, [command, series]));
                let moved = self.without_gain(channel, without_mean(series, stride));
                let is_held = self.is_held_at(driven, frequency(&moved, stride as f64 * record.spacing_s));
                let found = compare(&target, &moved, most, SAME_MOTION);
                if let Some(found) = found.filter(|_| is_held) {
                    let pair = [&channel.column, &driven.column];
                    let pair = pair.map(|column| self.reading(column, Quantity::Position));
                    let known = accused(r, pair, found.factor, NEAR_FORCE, false);
                    odd.extend(known.or_else(|| unlike(r, pair, found.factor)));
                }
            }
        }
    }

    /// Whether a position has a constant offset from its target that exceeds its motion and the offset that
    /// the servo's largest force can cause.
    fn beside(
        &self,
        record: usize,
        driven: &Driven,
        channel: &Channel,
        [target, position]: [&[f64]; 2],
    ) -> Option<Odd> {
        let drive = &self.assembly.drives[driven.drive];
        let (gain, bias) = channel.scale(&self.assembly);
        let held_off = drive.servo.as_ref().map_or(0.0, |servo| drive.limit / servo.kp);
        let mean = |series: &[f64]| series.iter().sum::<f64>() / series.len().max(1) as f64;
        let position: Vec<f64> = position.iter().map(|x| (x - bias) / gain).collect();
        let offset = mean(&position) - mean(target);
        let reach = [target, &position].map(range).into_iter().fold(0.0, f64::max);
        let least = if held_off.is_finite() { reach.max(held_off) } else { reach };
        (offset.abs() > least && least > 0.0).then(|| Odd {
            record,
            column: channel.column.clone(),
            kind: FaultKind::Beside { other: driven.column.clone(), offset, reach, experiments: 1 },
        })
    }

    /// Whether a channel reads the position that follows the target of a servo, or the recorded reference of
    /// a controller.
    fn is_followed_by(&self, driven: &Driven, channel: &Channel) -> bool {
        let dataset = self.dataset;
        if channel.quantity(&dataset.machine) != Quantity::Position {
            return false;
        }
        if let Some(looped) = dataset.loops.iter().find(|looped| looped.drive == driven.drive) {
            return looped.reading.is_some_and(|sensor| channel.source == Source::Sensor(sensor));
        }
        let drive = &self.assembly.drives[driven.drive];
        let source = match channel.source {
            Source::Sensor(sensor) => self.assembly.sensors[sensor].source,
            source => source,
        };
        let is_its = source == Source::Drive(driven.drive, Quantity::Position)
            || node_of(&dataset.machine, &self.assembly, channel)
                .is_some_and(|node| self.groups[node] == self.groups[drive.on]);
        drive.servo.is_some() && is_its
    }

    /// Whether a believed servo follows a target at this frequency, rad/s. Above its bandwidth the position
    /// may be far smaller than the target, or opposite in sign.
    fn is_held_at(&self, driven: &Driven, omega: f64) -> bool {
        let drive = &self.assembly.drives[driven.drive];
        drive.servo.as_ref().is_none_or(|servo| {
            let natural = (servo.kp / self.assembly.rigid_mass_kg(drive.on)).sqrt();
            omega < natural.min(servo.kp / servo.kd)
        })
    }
}

/// A fault if the motions of a target and of its position are too different for a working servo.
fn unlike(record: usize, [position, target]: [Reading<'_>; 2], factor: f64) -> Option<Odd> {
    let (larger, smaller, factor) =
        if factor > 1.0 { (position, target, factor) } else { (target, position, 1.0 / factor) };
    (factor > UNLIKE).then(|| Odd {
        record,
        column: larger.column.to_owned(),
        kind: FaultKind::Units { other: smaller.column.to_owned(), factor, what: COUNTS, experiments: 1 },
    })
}

fn range(series: &[f64]) -> f64 {
    let ends = series.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)]);
    ends[1] - ends[0]
}

/// Mean frequency of a zero-mean series, rad/s.
fn frequency(series: &[f64], spacing_s: f64) -> f64 {
    let square: f64 = series.iter().map(|x| x * x).sum();
    let rises: f64 = series.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    (rises / square).sqrt() / spacing_s
}

/// Every `stride`-th row of a series, less the mean.
fn without_mean(series: &[f64], stride: usize) -> Vec<f64> {
    let kept: Vec<f64> = series.iter().step_by(stride).copied().collect();
    let mean = kept.iter().sum::<f64>() / kept.len().max(1) as f64;
    kept.into_iter().map(|x| x - mean).collect()
}
