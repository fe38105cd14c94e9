//! Tests whether the missing force correlates with a possible explanation: command, position, direction,
//! speed, time, a frequency or a reversal.
//!
//! A residual has structure if it correlates with one of these beyond chance, and by an amount that matters.
//! Chance is measured by shifting the residual in time. The shifted residual keeps its spectrum, so that
//! coloured noise does not count as structure.

use std::f64::consts::TAU;

use serde::Serialize;

use super::criteria::Criteria;
use super::horizons::share;
use crate::fit::least_squares::Task;
use crate::fit::missing::{missing_acceleration, moving_mass};
use crate::fit::scored::Scored;
use crate::gap::unknown::explained;

/// Span over which the missing force is averaged, s: longer than the noise is correlated. A slow observer
/// needs at least this many radians of its natural frequency.
const AVERAGE_S: f64 = 0.02;
const AVERAGE_RADIANS: f64 = 0.8;
/// A prediction has forgotten its start after this many time constants of the observer.
const SETTLED: f64 = 6.0;
/// Share of the top speed over which the direction changes smoothly.
const SLOW: f64 = 0.05;
/// If chance reaches this share of the variance, a dependence cannot be distinguished from it.
const TELLING: f64 = 0.25;
/// Smallest number of points for a comparison.
const FEWEST_POINTS: usize = 60;
/// Largest number of points of a record for its spectrum.
const MOST_LINES: usize = 512;
/// Averaged points on either side of a reversal.
const BESIDE: usize = 3;
/// Smallest number of reversals at which a jump can be distinguished from chance, and the limit in standard
/// errors.
const FEWEST_REVERSALS: usize = 4;
const STANDARD_ERRORS: f64 = 3.0;

/// The part of the missing force that correlates with one quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualTrace {
    /// `command`, `position`, `direction`, `speed`, `time`, `one frequency` or `reversals`. A load, friction,
    /// damping or gain that drifts correlates with `time`.
    pub goes_with: &'static str,
    /// Root mean square of the correlated part, beyond what chance gives, N (or N m).
    pub rms_n: f64,
    /// Share of the variance that is correlated.
    pub share: f64,
    /// Share that chance reaches.
    pub chance: f64,
}

/// Structure of the missing force, with the root mean square of the drive force.
pub(super) struct Residual {
    pub(super) drive_force_n: f64,
    pub(super) traces: Vec<ResidualTrace>,
}

/// Averages over a short span of one record.
#[derive(Clone, Copy)]
struct Point {
    time: f64,
    position: f64,
    speed: f64,
    drive: f64,
    missing: f64,
}

pub(super) fn of(task: &Task<'_>, scored: &Scored, checks: &[usize], criteria: &Criteria) -> Residual {
    let records: Vec<Vec<Point>> =
        checks.iter().filter_map(|&r| points(task, scored, r)).filter(|points| !points.is_empty()).collect();
    let all: Vec<Point> = records.iter().flatten().copied().collect();
    let mean_square =
        |of: &dyn Fn(&Point) -> f64| all.iter().map(|p| of(p).powi(2)).sum::<f64>() / all.len().max(1) as f64;
    let drive_force_n = mean_square(&|p| p.drive).sqrt();
    if all.len() < FEWEST_POINTS || drive_force_n == 0.0 {
        return Residual { drive_force_n, traces: Vec::new() };
    }
    let rms = mean_square(&|p| p.missing).sqrt();
    let mut traces = regressions(&records, &all, rms, criteria);
    traces.push(frequency(&records, rms));
    traces.extend(reversals(&records, rms));
    Residual { drive_force_n, traces }
}

impl Residual {
    /// Whether the missing force depends on none of the tested quantities, and the records would show such a
    /// dependence.
    pub(super) fn is_noise(&self, criteria: &Criteria) -> bool {
        let is_chance = |trace: &ResidualTrace| {
            trace.share <= trace.chance && trace.rms_n < criteria.some_structure * self.drive_force_n
        };
        let is_telling = |trace: &ResidualTrace| trace.chance < TELLING;
        self.traces.iter().any(is_telling) && self.traces.iter().all(is_chance)
    }

    /// Describes structure that matters. `refitted` is the force missing after calibration.
    pub(super) fn shortfalls(&self, refitted: f64, criteria: &Criteria) -> Vec<String> {
        let matters = |trace: &&ResidualTrace| {
            let over_drive = trace.rms_n / self.drive_force_n;
            let is_most = trace.rms_n > criteria.most_of_missing_force * refitted;
            trace.share > trace.chance
                && (over_drive > criteria.most_structure || (over_drive > criteria.some_structure && is_most))
        };
        let say = |trace: &ResidualTrace| {
            format!(
                "a force of {} of the drive's that correlates with {} remains",
                share(trace.rms_n / self.drive_force_n),
                trace.goes_with
            )
        };
        self.traces.iter().filter(matters).map(say).collect()
    }
}

/// Says that records are too short to test a dependence, if nothing was tested.
pub(super) fn untested(traces: &[ResidualTrace]) -> Option<String> {
    traces.is_empty().then(|| {
        format!(
            "the check records have fewer than {FEWEST_POINTS} averages of {AVERAGE_S} s or more: too few to \
             show whether the missing force depends on command, position, speed or time (record longer, or \
             check more)"
        )
    })
}

/// Averages along a record once its prediction has settled; `None` if the model has no prediction.
fn points(task: &Task<'_>, scored: &Scored, r: usize) -> Option<Vec<Point>> {
    let record = &task.dataset.records[r];
    let prediction = task.predict(&scored.fitted.model, &scored.fitted.theta, r)?;
    let mass = moving_mass(task.dataset, scored);
    let missing = missing_acceleration(task.dataset, r, &prediction);
    let average_s = AVERAGE_S.max(AVERAGE_RADIANS / prediction.omega.max(1.0));
    let rows = ((average_s / record.spacing_s).round() as usize).max(1);
    let settled = (SETTLED / (prediction.omega.max(1.0) * record.spacing_s)).ceil() as usize;
    let from = settled.min(missing.len());
    let average = |(i, (stroke, missing)): (usize, (&[[f64; 3]], &[f64]))| {
        let n = missing.len() as f64;
        let of = |i: usize| stroke.iter().map(|row| row[i]).sum::<f64>() / n;
        let time = record.start_s + (from + i * rows) as f64 * record.spacing_s;
        let missing = mass * missing.iter().sum::<f64>() / n;
        Point { time, position: of(0), speed: of(1), drive: of(2), missing }
    };
    let pairs = prediction.stroke[from..].chunks_exact(rows).zip(missing[from..].chunks_exact(rows));
    Some(pairs.enumerate().map(average).collect())
}

/// A quantity: its name, columns that vary with it, and the shifted forces that measure chance.
type Group<'a> = (&'static str, Vec<Vec<f64>>, &'a [Vec<f64>]);

/// Regressions of the missing force, against the same regressions with the force shifted within records.
fn regressions(records: &[Vec<Point>], all: &[Point], rms: f64, criteria: &Criteria) -> Vec<ResidualTrace> {
    let column = |of: &dyn Fn(&Point) -> f64| all.iter().map(of).collect::<Vec<f64>>();
    let fast = all.iter().map(|p| p.speed.abs()).fold(1e-300, f64::max);
    let at = scaled(all, |p| p.position);
    let clock = scaled(all, |p| p.time);
    let speed = |p: &Point| p.speed / fast;
    let direction = |p: &Point| (speed(p) / SLOW).tanh();
    let drifts: [&dyn Fn(&Point) -> f64; 4] = [&|_| 1.0, &direction, &speed, &|p| p.drive];
    let missing = column(&|p| p.missing);
    // A shift within each record would keep a drift from record to record.
    let whole = [all.to_vec()];
    let shifted = |records: &[Vec<Point>]| -> Vec<Vec<f64>> {
        let of = |i: usize| {
            let share = i as f64 / (criteria.chance_shifts + 1) as f64;
            let turn = |points: &Vec<Point>| {
                let by = (share * points.len() as f64) as usize;
                let turned = points[by..].iter().chain(&points[..by]);
                turned.map(|p| p.missing).collect::<Vec<f64>>()
            };
            records.iter().flat_map(turn).collect()
        };
        (1..=criteria.chance_shifts).map(of).collect()
    };
    let [within, across] = [shifted(records), shifted(&whole)];
    let groups: [Group<'_>; 5] = [
        ("command", vec![column(&|p| p.drive)], &within),
        ("position", (1..=3).map(|n| column(&|p| at(p).powi(n))).collect(), &within),
        ("direction", vec![column(&direction)], &within),
        ("speed", vec![column(&speed), column(&|p| speed(p) * speed(p).abs())], &within),
        ("time", drifts.map(|of| column(&|p| clock(p) * of(p))).to_vec(), &across),
    ];
    groups
        .into_iter()
        .map(|(goes_with, columns, shifted)| {
            let share = explained(&columns, &missing);
            let by_chance: Vec<f64> = shifted.iter().map(|missing| explained(&columns, missing)).collect();
            let chance = by_chance.iter().copied().fold(0.0, f64::max);
            let usual = by_chance.iter().sum::<f64>() / by_chance.len().max(1) as f64;
            ResidualTrace { goes_with, rms_n: rms * (share - usual).max(0.0).sqrt(), share, chance }
        })
        .collect()
}

/// A quantity over its range, from minus one to one.
fn scaled(all: &[Point], of: fn(&Point) -> f64) -> impl Fn(&Point) -> f64 {
    let range = |(low, high): (f64, f64), p: &Point| (low.min(of(p)), high.max(of(p)));
    let (low, high) = all.iter().fold((f64::INFINITY, f64::NEG_INFINITY), range);
    let half = (0.5 * (high - low)).max(f64::MIN_POSITIVE);
    move |p| (of(p) - 0.5 * (low + high)) / half
}

/// The strongest line in the spectra of the records, relative to the level of its neighbours. Chance is the
/// strongest of as many lines of noise (Fisher's test at one in a hundred).
fn frequency(records: &[Vec<Point>], rms: f64) -> ResidualTrace {
    let mut best = ResidualTrace { goes_with: "one frequency", rms_n: 0.0, share: 0.0, chance: 1.0 };
    let energy: f64 = records.iter().flatten().map(|p| p.missing.powi(2)).sum();
    for points in records.iter().filter(|points| points.len() >= FEWEST_POINTS) {
        let series: Vec<f64> = points.iter().take(MOST_LINES).map(|p| p.missing).collect();
        let lines = periodogram(&series);
        let total: f64 = lines.iter().sum();
        let own: f64 = points.iter().map(|p| p.missing.powi(2)).sum::<f64>() / energy.max(f64::MIN_POSITIVE);
        // Critical share of the largest of `n` lines of white noise.
        let n = lines.len() as f64;
        let critical = 1.0 - (0.01 / n).powf(1.0 / (n - 1.0).max(1.0));
        for (k, line) in lines.iter().enumerate() {
            let around: Vec<f64> = (k.saturating_sub(NEIGHBOURS)..(k + NEIGHBOURS + 1).min(lines.len()))
                .filter(|&i| i.abs_diff(k) > 1)
                .map(|i| lines[i])
                .collect();
            let colour = around.iter().sum::<f64>() / around.len().max(1) as f64;
            let white = total / n;
            let beyond = (line - colour.max(white) * critical * n).max(0.0);
            let share = own * line / total.max(f64::MIN_POSITIVE);
            let others = || lines.iter().enumerate().filter(|(i, _)| is_apart(*i, k));
            if beyond > 0.0 && share > best.share && others().all(|(_, other)| *other <= OTHERS * line) {
                let rms_n = rms * (own * beyond / total).sqrt();
                best = ResidualTrace { rms_n, share, chance: own * critical, ..best };
            }
        }
    }
    best
}

/// Largest ratio of any other line to a line that stands for one frequency. Pulses at every reversal, or at
/// edges of the command between two rows, have many lines of similar height.
const OTHERS: f64 = 0.3;

/// Whether line `other` is neither a neighbour of line `of` nor one of its harmonics or fractions.
fn is_apart(other: usize, of: usize) -> bool {
    let [other, of] = [other + 1, of + 1];
    let [low, high] = [other.min(of), other.max(of)];
    let multiple = (high + low / 2) / low;
    high.abs_diff(multiple * low) > multiple
}

/// Number of lines on either side that define the local noise level.
const NEIGHBOURS: usize = 8;

/// Power of every spectral line except the mean.
fn periodogram(series: &[f64]) -> Vec<f64> {
    let n = series.len();
    let mean = series.iter().sum::<f64>() / n as f64;
    (1..n / 2)
        .map(|line| {
            let (sine, cosine) = series.iter().enumerate().fold((0.0, 0.0), |(s, c), (k, y)| {
                let turn = TAU * (line * k % n) as f64 / n as f64;
                (s + turn.sin() * (y - mean), c + turn.cos() * (y - mean))
            });
            sine * sine + cosine * cosine
        })
        .collect()
}

/// Mean jump of the missing force over all reversals of the motion.
fn reversals(records: &[Vec<Point>], rms: f64) -> Option<ResidualTrace> {
    let jump = |window: &[Point]| {
        let (before, after) = window.split_at(BESIDE);
        let keeps = |side: &[Point]| side.iter().all(|p| p.speed.signum() == side[0].speed.signum());
        let turns = before[0].speed.signum() != after[0].speed.signum();
        let mean = |side: &[Point]| side.iter().map(|p| p.missing).sum::<f64>() / BESIDE as f64;
        (keeps(before) && keeps(after) && turns)
            .then(|| after[0].speed.signum() * (mean(after) - mean(before)))
    };
    let jumps: Vec<f64> =
        records.iter().flat_map(|points| points.windows(2 * BESIDE).filter_map(jump)).collect();
    if jumps.len() < FEWEST_REVERSALS {
        return None;
    }
    let n = jumps.len() as f64;
    let mean = jumps.iter().sum::<f64>() / n;
    let deviation = (jumps.iter().map(|j| (j - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let by_chance = STANDARD_ERRORS * deviation / n.sqrt();
    // A jump between opposite levels has a root mean square of half its height.
    let over = |jump: f64| (0.5 * jump / rms.max(f64::MIN_POSITIVE)).powi(2).min(1.0);
    Some(ResidualTrace {
        goes_with: "reversals",
        rms_n: 0.5 * (mean.abs() - by_chance).max(0.0),
        share: over(mean),
        chance: over(by_chance),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    /// Deterministic uniform noise of unit deviation.
    fn noise(n: usize) -> Vec<f64> {
        let mut chance = Chance::seeded(5);
        (0..n).map(|_| chance.deviate()).collect()
    }

    /// Motion of two incommensurate sines, with a missing force of the given shape and noise of 1 N.
    fn record(missing: impl Fn(f64, f64, f64) -> f64) -> Vec<Point> {
        noise(600)
            .into_iter()
            .enumerate()
            .map(|(k, noise)| {
                let t = 0.02 * k as f64;
                let (x, v) =
                    ((1.3 * t).sin() + 0.4 * (3.1 * t).sin(), 1.3 * (1.3 * t).cos() + 1.24 * (3.1 * t).cos());
                Point { time: t, position: x, speed: v, drive: 10.0, missing: missing(x, v, t) + noise }
            })
            .collect()
    }

    fn found(missing: impl Fn(f64, f64, f64) -> f64) -> Vec<&'static str> {
        let records = vec![record(missing)];
        let all: Vec<Point> = records.iter().flatten().copied().collect();
        let rms = (all.iter().map(|p| p.missing.powi(2)).sum::<f64>() / all.len() as f64).sqrt();
        let criteria = Criteria::default();
        let mut traces = regressions(&records, &all, rms, &criteria);
        traces.push(frequency(&records, rms));
        traces.extend(reversals(&records, rms));
        let residual = Residual { drive_force_n: 10.0, traces };
        let told = residual
            .traces
            .iter()
            .filter(|t| t.share > t.chance && t.rms_n / residual.drive_force_n > criteria.most_structure);
        told.map(|trace| trace.goes_with).collect()
    }

    #[test]
    fn truth_only_what_could_be_told_from_chance_is_noise() {
        let of = |share, chance, rms_n| {
            let trace = ResidualTrace { goes_with: "speed", rms_n, share, chance };
            Residual { drive_force_n: 10.0, traces: vec![trace] }.is_noise(&Criteria::default())
        };
        assert!(of(0.01, 0.02, 0.0));
        // Small but certain; as large as chance because there are few points; large.
        assert!(!of(0.3, 0.02, 0.4) && !of(0.3, 0.4, 0.0) && !of(0.01, 0.02, 0.6));
    }

    #[test]
    fn truth_noise_goes_with_nothing() {
        assert!(found(|_, _, _| 0.0).is_empty());
    }

    #[test]
    fn truth_a_level_goes_with_direction_and_jumps_at_reversals() {
        let told = found(|_, v, _| 3.0 * v.signum());
        assert!(told.contains(&"direction") && told.contains(&"reversals"), "{told:?}");
    }

    #[test]
    fn truth_a_force_over_position_and_one_over_time_are_told() {
        assert!(found(|x, _, _| 3.0 * x.powi(3)).contains(&"position"));
        assert!(found(|_, _, t| 3.0 * (TAU * 7.0 * t).sin()).contains(&"one frequency"));
    }

    /// Three lines of one height, none of them a harmonic of another.
    #[test]
    fn truth_many_lines_of_one_height_are_not_one_frequency() {
        let lines = found(|_, _, t| [5.1, 7.3, 11.7].map(|hz| 3.0 * (TAU * hz * t).sin()).iter().sum());
        assert!(!lines.contains(&"one frequency"), "{lines:?}");
    }

    #[test]
    fn truth_friction_that_falls_while_a_guide_warms_goes_with_time_alone() {
        let told = found(|_, v, t| 0.5 * (t - 6.0) * v.signum());
        assert_eq!(told, ["time"]);
    }
}
