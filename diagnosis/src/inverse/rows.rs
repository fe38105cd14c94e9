//! Records prepared for a balance of forces: motion and command, low-passed far above the motion.

use std::f64::consts::TAU;

use crate::filter;
use crate::fit::leeway::MOST_LATE_ROWS;
use crate::kinds::{At, Extent};

/// Ratio of the low-pass corner to the frequency of the motion.
const ABOVE_MOTION: f64 = 6.0;
/// Largest corner, in cycles per row.
const MOST_CORNER: f64 = 0.15;
/// Ratio of the low-pass corner for motion in nonlinear terms to the main corner. Strong smoothing before a
/// nonlinear term would change its instants and its size.
const LIGHT: f64 = 2.0;
/// Rows per period of the corner at which terms are computed, and the number that is kept. At this density
/// the instant of a reversal between two rows has no effect.
const ROWS_PER_CORNER: f64 = 48.0;
const KEPT_PER_CORNER: f64 = 4.0;
/// Periods of the corner that are omitted at either end, where the low-pass settles.
const ENDS: f64 = 1.0;
/// A guide is at rest, or creeps, where its position changes by fewer deviations of its readings than this.
/// It does so before the row or after it, within this share of a period of the corner, at least this number
/// of rows. At the turning point of a sine the position changes by a thirtieth of the amplitude in that
/// share.
const AT_REST: f64 = 6.0;
const RESTING: f64 = 0.25;
const FEWEST_RESTING: usize = 6;

/// The measured series of one experiment.
pub(super) struct Measured<'a> {
    pub(super) start_s: f64,
    pub(super) spacing_s: f64,
    pub(super) command: &'a [f64],
    pub(super) position: &'a [f64],
    /// Standard deviation of a position's reading. Zero keeps rows at rest.
    pub(super) sigma: f64,
    /// Whether each command is held until the next row.
    pub(super) is_held: bool,
}

/// How late the force of a drive follows its command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Late {
    pub(super) lag_s: f64,
    pub(super) delay_s: f64,
}

/// A prepared experiment.
pub(super) struct Rows {
    /// Spacing of the rows at which terms are computed: in s, and in rows of the record.
    spacing_s: f64,
    apart: usize,
    corner_hz: f64,
    /// The kept rows.
    kept: Vec<usize>,
    /// The measured command, row by row, low-passed at the corner for nonlinear terms. A limit would
    /// otherwise clip the noise of a command that stays near it.
    command: Vec<f64>,
    measured_spacing_s: f64,
    /// The low-passed command, and its rate.
    pub(super) smooth: Vec<f64>,
    pub(super) command_rate: Vec<f64>,
    /// Low-passed speed and acceleration: with the rows at rest, and without.
    with_rest: [Vec<f64>; 2],
    moving: [Vec<f64>; 2],
    /// Position and speed for nonlinear terms, with a higher corner.
    position: Vec<f64>,
    light_speed: Vec<f64>,
    /// Whether the guide moves. At rest, dry friction is whatever balances the other forces. All forces of
    /// these rows are therefore taken as zero before they are low-passed.
    moves: Vec<bool>,
    /// See [`At::direction`].
    direction: Vec<f64>,
    /// Weights of the kept rows.
    pub(super) weights: Vec<f64>,
    /// See [`At::middle`].
    pub(super) middle: f64,
    /// Time of the first row, s.
    start_s: f64,
}

/// Corner frequency of the low-pass for a motion of frequency `motion`, rad/s.
pub(super) fn corner_hz(motion: f64, spacing_s: f64) -> f64 {
    (ABOVE_MOTION * motion / TAU).min(MOST_CORNER / spacing_s)
}

impl Rows {
    pub(super) fn new(measured: &Measured<'_>, corner_hz: f64) -> Self {
        let measured_spacing_s = measured.spacing_s;
        let position = smoothed(measured.position, corner_hz, measured_spacing_s);
        let light = smoothed(measured.position, LIGHT * corner_hz, measured_spacing_s);
        let speed = slope(&position, measured_spacing_s);
        let light_speed = slope(&light, measured_spacing_s);
        let acceleration = slope(&speed, measured_spacing_s);
        let apart = ((1.0 / (corner_hz * measured_spacing_s * ROWS_PER_CORNER)) as usize).max(1);
        let spacing_s = apart as f64 * measured_spacing_s;
        let few = |series: &[f64]| series.iter().step_by(apart).copied().collect::<Vec<f64>>();
        let (position, light_speed) = (few(&light), few(&light_speed));
        let step = ((1.0 / (corner_hz * spacing_s * KEPT_PER_CORNER)).round() as usize).max(1);
        let end = ((ENDS / (corner_hz * spacing_s)) as usize).min(position.len() / 4);
        let resting = ((RESTING / (corner_hz * spacing_s)) as usize).max(FEWEST_RESTING);
        let moves = moving(&few(measured.position), resting, AT_REST * measured.sigma);
        let kept = (end..position.len() - end).step_by(step).filter(|k| moves[*k]).collect();
        let commands =
            if measured.is_held { half_a_row_later(measured.command) } else { measured.command.into() };
        let command = |series: &[f64]| {
            let moved = |(k, u): (usize, &f64)| if moves[k / apart] { *u } else { 0.0 };
            let series: Vec<f64> = series.iter().enumerate().map(moved).collect();
            few(&smoothed(&series, corner_hz, measured_spacing_s))
        };
        let (smooth, command_rate) = (command(&commands), command(&slope(&commands, measured_spacing_s)));
        let mut rows = Self {
            spacing_s,
            apart,
            corner_hz,
            kept,
            command: smoothed(&commands, LIGHT * corner_hz, measured_spacing_s),
            measured_spacing_s,
            smooth,
            command_rate,
            position,
            moves,
            direction: light_speed.iter().map(|v| v.signum()).collect(),
            light_speed,
            with_rest: [few(&speed), few(&acceleration)],
            moving: Default::default(),
            weights: Vec::new(),
            middle: 0.0,
            start_s: measured.start_s,
        };
        rows.moving = [0, 1].map(|order| rows.without_rest(order, Late::default()));
        rows.weights = vec![1.0; rows.kept.len()];
        rows
    }

    pub(super) fn times_s(&self) -> Vec<f64> {
        (0..self.position.len()).map(|k| self.start_s + k as f64 * self.spacing_s).collect()
    }

    /// The kept rows of a series.
    pub(super) fn thin(&self, series: &[f64]) -> Vec<f64> {
        self.kept.iter().map(|&k| series[k]).collect()
    }

    /// The kept rows of a series, times their weights.
    pub(super) fn weighed(&self, series: &[f64]) -> Vec<f64> {
        self.thin(series).iter().zip(&self.weights).map(|(x, weight)| x * weight).collect()
    }

    /// The low-passed command after `change` is applied to every row. What `change` leaves alone stays as in
    /// [`Self::smooth`].
    pub(super) fn command(&self, change: impl Fn(f64) -> f64) -> Vec<f64> {
        let moved = |k: usize, change: f64| if self.moves[k / self.apart] { change } else { 0.0 };
        let changes: Vec<f64> =
            self.command.iter().enumerate().map(|(k, u)| moved(k, change(*u) - u)).collect();
        let changes = smoothed(&changes, self.corner_hz, self.measured_spacing_s);
        self.smooth.iter().zip(changes.iter().step_by(self.apart)).map(|(u, change)| u + change).collect()
    }

    /// Sets the direction to that of friction in a guide with presliding distance `way_m`. The friction
    /// approaches its level exponentially with the distance moved (Dahl, Solid Friction Damping of Mechanical
    /// Vibrations, AIAA Journal 14, 1976).
    pub(super) fn turn_over(&mut self, way_m: f64) {
        let mut direction = self.light_speed.first().map_or(0.0, |v| v.signum());
        for k in 0..self.light_speed.len() {
            let [from, to] = [self.light_speed[k.saturating_sub(1)], self.light_speed[k]];
            // If the motion reverses between two rows, both directions count. A reversal that took effect
            // only at the next row would look like a delay.
            let turn = from / (from - to);
            let shares = if from * to < 0.0 { [turn, 1.0 - turn] } else { [1.0; 2] };
            for (speed, share) in [from, to].into_iter().zip(shares) {
                let moved = 0.5 * speed * share * self.spacing_s;
                let left = (-moved.abs() / way_m.max(f64::MIN_POSITIVE)).exp();
                direction = moved.signum() + (direction - moved.signum()) * left;
            }
            self.direction[k] = direction;
        }
    }

    /// The speed, low-passed, if the drive's force is late.
    pub(super) fn speed(&self, late: Late) -> Vec<f64> {
        self.derivative(0, late)
    }

    /// The acceleration, likewise.
    pub(super) fn acceleration(&self, late: Late) -> Vec<f64> {
        self.derivative(1, late)
    }

    fn derivative(&self, order: usize, late: Late) -> Vec<f64> {
        if late == Late::default() { self.moving[order].clone() } else { self.without_rest(order, late) }
    }

    /// A derivative without its part in rows at rest. That part is subtracted after the low-pass, so that the
    /// other rows stay as they are.
    fn without_rest(&self, order: usize, late: Late) -> Vec<f64> {
        let light = if order == 0 { self.light_speed.clone() } else { self.rate(&self.light_speed) };
        let rest = self.earlier_by(late, light, |_| true);
        let rest: Vec<f64> =
            rest.iter().zip(&self.moves).map(|(x, moves)| if *moves { 0.0 } else { *x }).collect();
        let all = self.earlier_by(late, self.with_rest[order].clone(), |_| true);
        all.iter().zip(smoothed(&rest, self.corner_hz, self.spacing_s)).map(|(x, rest)| x - rest).collect()
    }

    /// A series of the motion as the late command sees it: with its rate where `has_rate`, and shifted.
    fn earlier_by(&self, late: Late, mut series: Vec<f64>, has_rate: impl Fn(usize) -> bool) -> Vec<f64> {
        if late.lag_s > 0.0 {
            let rate = self.rate(&series);
            for (k, (x, rate)) in series.iter_mut().zip(rate).enumerate() {
                *x += if has_rate(k) { late.lag_s * rate } else { 0.0 };
            }
        }
        if late.delay_s > 0.0 { self.earlier(&series, late.delay_s) } else { series }
    }

    /// A function of the motion at every row, low-passed, if the drive's force is late.
    pub(super) fn of_motion(&self, late: Late, shape: f64, f: impl Fn(At) -> f64) -> Vec<f64> {
        let at = |k: usize| At {
            position: self.position[k],
            middle: self.middle,
            speed: self.light_speed[k],
            direction: self.direction[k],
            shape,
        };
        let values = (0..self.position.len()).map(|k| f(at(k))).collect();
        // At the end of a rest, friction changes over without a rate.
        let goes_on =
            |k: usize| self.moves[k.saturating_sub(1)..(k + 2).min(self.moves.len())].iter().all(|m| *m);
        let values = self.earlier_by(late, values, goes_on);
        self.while_moving(|k| values[k])
    }

    /// A function of the command at every row, low-passed.
    pub(super) fn of_command(&self, f: impl Fn(f64) -> f64) -> Vec<f64> {
        self.while_moving(|k| f(self.command[k * self.apart]))
    }

    /// Share that friction lacks of its level, low-passed: all of it at rest.
    pub(super) fn lacks(&self) -> Vec<f64> {
        let lacks = |(d, moves): (&f64, &bool)| if *moves { 1.0 - d.abs() } else { 1.0 };
        let values: Vec<f64> = self.direction.iter().zip(&self.moves).map(lacks).collect();
        smoothed(&values, self.corner_hz, self.spacing_s)
    }

    fn while_moving(&self, f: impl Fn(usize) -> f64) -> Vec<f64> {
        let values: Vec<f64> =
            self.moves.iter().enumerate().map(|(k, moves)| if *moves { f(k) } else { 0.0 }).collect();
        smoothed(&values, self.corner_hz, self.spacing_s)
    }

    /// A series shifted earlier by `by_s`, interpolated between rows; its ends are held.
    fn earlier(&self, series: &[f64], by_s: f64) -> Vec<f64> {
        let last = series.len() - 1;
        (0..series.len())
            .map(|i| {
                let at = (i as f64 + by_s / self.spacing_s).clamp(0.0, last as f64);
                let low = (at as usize).min(last.saturating_sub(1));
                series[low] + (at - low as f64) * (series[(low + 1).min(last)] - series[low])
            })
            .collect()
    }

    /// Largest shift of a command without a stated hold, s: it may act earlier or later.
    pub(super) fn most_late_s(&self) -> f64 {
        MOST_LATE_ROWS * self.measured_spacing_s
    }

    /// Slope of a series, per second.
    fn rate(&self, series: &[f64]) -> Vec<f64> {
        slope(series, self.spacing_s)
    }

    /// Extent of several experiments.
    pub(super) fn extent(rows: &[Self]) -> Extent {
        let over = |of: &dyn Fn(&Self) -> Vec<f64>| rows.iter().flat_map(of).collect::<Vec<f64>>();
        let positions = over(&|rows| rows.thin(&rows.position));
        let (low, high) =
            positions.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let commands = over(&|rows| rows.smooth.clone());
        Extent {
            speed: rms(&over(&|rows| rows.thin(&rows.moving[0]))),
            ends: [low, high],
            command: commands.iter().fold(0.0, |most, u| most.max(u.abs())),
            resolved_s: 1.0 / (TAU * rows.iter().map(|rows| rows.corner_hz).fold(0.0, f64::max)),
        }
    }
}

/// Commands as they act on average if each is held until the next: half a row later, by cubic interpolation.
fn half_a_row_later(commands: &[f64]) -> Vec<f64> {
    let last = commands.len().saturating_sub(1);
    let at = |k: usize| commands[k.saturating_sub(2).min(last)];
    let mean = |k: usize| (9.0 * (at(k + 1) + at(k + 2)) - at(k) - at(k + 3)) / 16.0;
    (0..commands.len()).map(mean).collect()
}

/// Whether a position changes by at least `least` within `rows` before and after each row.
fn moving(position: &[f64], rows: usize, least: f64) -> Vec<bool> {
    let range = |near: &[f64]| {
        let [low, high] =
            near.iter().fold([f64::INFINITY, -f64::INFINITY], |[l, h], x| [l.min(*x), h.max(*x)]);
        high - low
    };
    let last = position.len().saturating_sub(1);
    (0..position.len())
        .map(|k| {
            range(&position[k.saturating_sub(rows)..=k]) >= least
                && range(&position[k..=(k + rows).min(last)]) >= least
        })
        .collect()
}

pub(super) fn rms(series: &[f64]) -> f64 {
    (series.iter().map(|x| x * x).sum::<f64>() / series.len().max(1) as f64).sqrt()
}

fn smoothed(series: &[f64], corner_hz: f64, spacing_s: f64) -> Vec<f64> {
    filter::low_pass(series, corner_hz * spacing_s)
}

/// Slope of a series, per second.
fn slope(series: &[f64], spacing_s: f64) -> Vec<f64> {
    filter::slope(series).into_iter().map(|slope| slope / spacing_s).collect()
}
