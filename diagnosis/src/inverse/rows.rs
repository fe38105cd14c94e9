//! Records prepared for a balance of forces: motion and command, low-passed far above the motion.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::ops::Deref;
use std::sync::Mutex;

use super::reversal::Reversal;
use crate::dataset::rms;
use crate::filter;
use crate::kinds::{At, Extent};
use crate::predict::MOST_LATE_ROWS;

/// Ratio of the low-pass corner to the frequency of the motion.
const ABOVE_MOTION: f64 = 6.0;
/// Largest corner, in cycles per row.
const MOST_CORNER: f64 = 0.15;
/// Largest corner of that speed, in cycles per row.
const MOST_TURNING: f64 = 0.45;
/// Ratio of the low-pass corner for motion in nonlinear terms to the main corner. Strong smoothing before a
/// nonlinear term would change its instants and its size.
const LIGHT: f64 = 2.0;
/// Ratios of the low-pass corner of the speed that decides reversals to that of motion in nonlinear terms.
/// Strong smoothing moves a reversal, since the acceleration changes at it.
const SHARPNESS: [f64; 3] = [1.0, 2.0, 4.0];
/// Rows per period of the corner at which terms are computed, and the number that is kept. At this density
/// the instant of a reversal between two rows has no effect.
const ROWS_PER_CORNER: f64 = 48.0;
const KEPT_PER_CORNER: f64 = 4.0;
/// Periods of the corner that are omitted at either end, where the low-pass settles.
const ENDS: f64 = 1.0;

/// Most values of forces that all experiments keep: 64 MB.
pub(super) const MOST_KEPT_VALUES: usize = 1 << 23;

/// A force of the motion: a side of the believed machine by its number, or a force of a cause by the address
/// of its function and its shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Named {
    Side(usize),
    Cause(usize, u64),
}

/// The measured series of one experiment.
pub(super) struct Measured<'a> {
    pub(super) start_s: f64,
    pub(super) spacing_s: f64,
    pub(super) command: &'a [f64],
    pub(super) position: &'a [f64],
    /// Whether each command is held until the next row.
    pub(super) is_held: bool,
}

/// A prepared experiment.
pub(super) struct Rows {
    /// Spacing of the rows at which terms are computed: in s, and in rows of the record.
    spacing_s: f64,
    apart: usize,
    corner_hz: f64,
    /// Number of rows omitted at either end, and spacing of the kept rows.
    end: usize,
    kept: usize,
    /// The measured command, row by row, low-passed at the corner for nonlinear terms. A limit would
    /// otherwise clip the noise of a command that stays near it.
    command: Vec<f64>,
    measured_spacing_s: f64,
    /// The low-passed command, and its rate.
    pub(super) smooth: Vec<f64>,
    pub(super) command_rate: Vec<f64>,
    /// Low-passed speed and acceleration.
    pub(super) speed: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
    /// Position and speeds for nonlinear terms, with a higher corner. Later speeds are sharper, for
    /// reversals.
    position: Vec<f64>,
    light_speeds: Vec<Vec<f64>>,
    /// Weights of the kept rows.
    pub(super) weights: Vec<f64>,
    /// See [`At::load`].
    load: Vec<f64>,
    /// See [`At::middle`].
    pub(super) middle: f64,
    /// Time of the first row, s.
    start_s: f64,
    /// Forces of the motion without reversals that have been computed, and the most values that are kept of
    /// them.
    pub(super) most_kept_values: usize,
    kept_forces: Kept,
}

type Kept = Mutex<HashMap<Named, Vec<f64>>>;

/// How friction turns during an experiment.
pub(super) struct Turning {
    /// See [`At::direction`].
    direction: Vec<f64>,
    /// Forces with these reversals that have been computed.
    kept_forces: Kept,
}

/// How friction turns in all experiments.
#[derive(Default)]
pub(super) struct Reversals {
    pub(super) reversal: Reversal,
    pub(super) fitted: Vec<Turning>,
    pub(super) checked: Vec<Turning>,
}

/// An experiment in which friction turns in one way.
#[derive(Clone, Copy)]
pub(super) struct Moving<'a> {
    rows: &'a Rows,
    turning: &'a Turning,
}

impl Deref for Moving<'_> {
    type Target = Rows;

    fn deref(&self) -> &Rows {
        self.rows
    }
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
        let acceleration = slope(&speed, measured_spacing_s);
        let apart = ((1.0 / (corner_hz * measured_spacing_s * ROWS_PER_CORNER)) as usize).max(1);
        let spacing_s = apart as f64 * measured_spacing_s;
        let few = |series: &[f64]| series.iter().step_by(apart).copied().collect::<Vec<f64>>();
        let position = few(&light);
        let most = MOST_TURNING / measured_spacing_s;
        let corners = SHARPNESS.map(|sharpness| sharpness * LIGHT * corner_hz);
        let is_used = |(i, corner): &(usize, &f64)| *i == 0 || **corner <= most;
        let of_corner = |(_, corner): (usize, &f64)| {
            few(&slope(&smoothed(measured.position, *corner, measured_spacing_s), measured_spacing_s))
        };
        let light_speeds = corners.iter().enumerate().filter(is_used).map(of_corner).collect();
        let kept = ((1.0 / (corner_hz * spacing_s * KEPT_PER_CORNER)).round() as usize).max(1);
        let end = ((ENDS / (corner_hz * spacing_s)) as usize).min(position.len() / 4);
        let commands =
            if measured.is_held { half_a_row_later(measured.command) } else { measured.command.into() };
        let smooth = few(&smoothed(&commands, corner_hz, measured_spacing_s));
        let mut rows = Self {
            spacing_s,
            apart,
            corner_hz,
            end,
            kept,
            command: smoothed(&commands, LIGHT * corner_hz, measured_spacing_s),
            measured_spacing_s,
            command_rate: slope(&smooth, spacing_s),
            smooth,
            position,
            light_speeds,
            speed: few(&speed),
            acceleration: few(&acceleration),
            weights: Vec::new(),
            load: Vec::new(),
            middle: 0.0,
            start_s: measured.start_s,
            most_kept_values: 0,
            kept_forces: Kept::default(),
        };
        rows.weights = vec![1.0; rows.thin(&rows.speed).len()];
        rows
    }

    /// Sets the load of a guide from its size over position.
    pub(super) fn carry(&mut self, size: impl Fn(f64) -> f64) {
        self.load = self.position.iter().map(|x| size(*x)).collect();
    }

    pub(super) fn times_s(&self) -> Vec<f64> {
        (0..self.position.len()).map(|k| self.start_s + k as f64 * self.spacing_s).collect()
    }

    /// The kept rows of a series.
    pub(super) fn thin(&self, series: &[f64]) -> Vec<f64> {
        series[self.end..series.len() - self.end].iter().step_by(self.kept).copied().collect()
    }

    /// Time between two kept rows, s.
    pub(super) fn kept_s(&self) -> f64 {
        self.kept as f64 * self.spacing_s
    }

    /// The kept rows of a series, times their weights.
    pub(super) fn weighed(&self, series: &[f64]) -> Vec<f64> {
        self.thin(series).iter().zip(&self.weights).map(|(x, weight)| x * weight).collect()
    }

    /// The low-passed command after `change` is applied to every row. What `change` leaves alone stays as in
    /// [`Self::smooth`].
    pub(super) fn command(&self, change: impl Fn(f64) -> f64) -> Vec<f64> {
        let changes: Vec<f64> = self.command.iter().map(|u| change(*u) - u).collect();
        let changes = smoothed(&changes, self.corner_hz, self.measured_spacing_s);
        self.smooth.iter().zip(changes.iter().step_by(self.apart)).map(|(u, change)| u + change).collect()
    }

    /// Index of the greatest sharpness of reversals.
    pub(super) fn sharpest(&self) -> usize {
        self.light_speeds.len() - 1
    }

    /// How friction turns if the guide gives way. It approaches its level exponentially with the distance
    /// moved (Dahl, Solid Friction Damping of Mechanical Vibrations, AIAA Journal 14, 1976). Damping of the
    /// bristles adds its rate: without that a drive would appear to lag.
    pub(super) fn turning(&self, Reversal { length_m, lead_s, sharpness }: Reversal) -> Turning {
        let speed = &self.light_speeds[sharpness];
        let mut now = speed.first().map_or(0.0, |v| v.signum());
        let of_row = |k: usize| {
            let [from, to] = [speed[k.saturating_sub(1)], speed[k]];
            // If the motion reverses between two rows, both directions count. A reversal that took effect
            // only at the next row would look like a delay.
            let turn = from / (from - to);
            let shares = if from * to < 0.0 { [turn, 1.0 - turn] } else { [1.0; 2] };
            for (speed, share) in [from, to].into_iter().zip(shares) {
                let moved = 0.5 * speed * share * self.spacing_s;
                let left = (-moved.abs() / length_m.max(f64::MIN_POSITIVE)).exp();
                now = moved.signum() + (now - moved.signum()) * left;
            }
            now
        };
        let mut direction: Vec<f64> = (0..speed.len()).map(of_row).collect();
        if lead_s > 0.0 {
            let rate = slope(&direction, self.spacing_s);
            direction.iter_mut().zip(rate).for_each(|(direction, rate)| *direction += lead_s * rate);
        }
        Turning { direction, kept_forces: Kept::default() }
    }

    pub(super) fn moving<'a>(&'a self, turning: &'a Turning) -> Moving<'a> {
        Moving { rows: self, turning }
    }

    /// A series shifted earlier by `by_s`, interpolated between rows; its ends are held.
    pub(super) fn earlier(&self, series: &[f64], by_s: f64) -> Vec<f64> {
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

    /// Whether a kept row is nearer to a position than `within_m`.
    pub(super) fn come_near(&self, position: f64, within_m: f64) -> bool {
        self.thin(&self.position).iter().any(|x| (x - position).abs() < within_m)
    }

    /// Slope of a series, per second.
    pub(super) fn rate(&self, series: &[f64]) -> Vec<f64> {
        slope(series, self.spacing_s)
    }

    /// Extent of several experiments.
    pub(super) fn extent(rows: &[Self]) -> Extent {
        let over = |of: &dyn Fn(&Self) -> Vec<f64>| rows.iter().flat_map(of).collect::<Vec<f64>>();
        let positions = over(&|rows| rows.thin(&rows.position));
        let (low, high) =
            positions.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let mut commands = over(&|rows| rows.smooth.iter().map(|u| u.abs()).collect());
        commands.sort_by(f64::total_cmp);
        Extent {
            speed: rms(&over(&|rows| rows.thin(&rows.speed))),
            ends: [low, high],
            command: commands.last().copied().unwrap_or(0.0),
            usual_command: commands.get(commands.len() / 2).copied().unwrap_or(0.0),
            resolved_s: 1.0 / (TAU * rows.iter().map(|rows| rows.corner_hz).fold(0.0, f64::max)),
        }
    }
}

impl Moving<'_> {
    /// See [`At::direction`].
    #[cfg(test)]
    pub(super) fn directions(&self) -> &[f64] {
        &self.turning.direction
    }

    /// A force of the motion, as [`Self::of_motion`]. It is kept if there is room. `is_dry` says whether it
    /// depends on the direction of friction.
    pub(super) fn force(&self, named: Named, is_dry: bool, shape: f64, f: impl Fn(At) -> f64) -> Vec<f64> {
        let kept = if is_dry { &self.turning.kept_forces } else { &self.rows.kept_forces };
        let kept = || kept.lock().ok();
        if let Some(known) = kept().and_then(|kept| kept.get(&named).cloned()) {
            return known;
        }
        let force = self.of_motion(shape, f);
        if let Some(mut kept) = kept().filter(|kept| (kept.len() + 1) * force.len() <= self.most_kept_values)
        {
            kept.insert(named, force.clone());
        }
        force
    }

    /// A function of the motion at every row, low-passed.
    pub(super) fn of_motion(&self, shape: f64, f: impl Fn(At) -> f64) -> Vec<f64> {
        let at = |k: usize| At {
            position: self.position[k],
            middle: self.middle,
            speed: self.light_speeds[0][k],
            load: self.load[k],
            direction: self.turning.direction[k],
            shape,
        };
        let values: Vec<f64> = (0..self.position.len()).map(|k| f(at(k))).collect();
        smoothed(&values, self.corner_hz, self.spacing_s)
    }
}

/// Commands as they act on average if each is held until the next: half a row later, by cubic interpolation.
fn half_a_row_later(commands: &[f64]) -> Vec<f64> {
    let last = commands.len().saturating_sub(1);
    let at = |k: usize| commands[k.saturating_sub(2).min(last)];
    let mean = |k: usize| (9.0 * (at(k + 1) + at(k + 2)) - at(k) - at(k + 3)) / 16.0;
    (0..commands.len()).map(mean).collect()
}

/// Mean square that is left of white noise of unit deviation in rows of a command.
pub(super) fn left_of_noise(command: &[f64], corner_hz: f64, spacing_s: f64) -> f64 {
    let mut impulse = vec![0.0; command.len()];
    if let Some(middle) = impulse.get_mut(command.len() / 2) {
        *middle = 1.0;
    }
    smoothed(&impulse, corner_hz, spacing_s).iter().map(|x| x * x).sum()
}

fn smoothed(series: &[f64], corner_hz: f64, spacing_s: f64) -> Vec<f64> {
    filter::low_pass(series, corner_hz * spacing_s)
}

/// Slope of a series, per second.
fn slope(series: &[f64], spacing_s: f64) -> Vec<f64> {
    filter::slope(series).into_iter().map(|slope| slope / spacing_s).collect()
}
