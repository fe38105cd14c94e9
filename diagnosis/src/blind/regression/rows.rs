//! Prepared records: motion and command, low-passed far above the motion and decimated to a few rows per
//! period.

use crate::filter::{low_pass, slope};

/// Ratio of the low-pass corner to the frequency of the motion.
const ABOVE_MOTION: f64 = 6.0;
/// Iterations that find the frequency of the motion.
const ROUNDS: usize = 8;
/// Rows kept per period of the corner.
const ROWS_PER_CORNER: f64 = 4.0;
/// Periods of the corner that are left out at either end.
const ENDS: f64 = 1.0;
/// Speed, over the root mean square speed, within which the smooth sign of a speed changes.
const SIGN_SHARE: f64 = 0.005;

/// The measurements of one experiment, SI.
#[derive(Clone, Debug)]
pub(in super::super) struct Measured {
    pub(in super::super) spacing_s: f64,
    pub(in super::super) command: Vec<f64>,
    pub(in super::super) position: Vec<f64>,
    pub(in super::super) is_check: bool,
}

/// A prepared experiment.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    spacing_s: f64,
    /// Corner of the low-pass, cycles per row.
    corner: f64,
    /// Rows that are kept: first row, last row and spacing.
    kept: [usize; 3],
    command: Vec<f64>,
    pub(super) position: Vec<f64>,
    pub(super) speed: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
    pub(super) is_check: bool,
}

impl Rows {
    /// Prepares the rows of an experiment; `corner_hz` as found by [`corner_hz`].
    pub(super) fn new(measured: &Measured, corner_hz: f64) -> Self {
        let spacing_s = measured.spacing_s;
        let corner = corner_hz * spacing_s;
        let position = low_pass(&measured.position, corner);
        let per_second = |series: &[f64]| slope(series).iter().map(|x| x / spacing_s).collect::<Vec<f64>>();
        let speed = per_second(&position);
        let acceleration = per_second(&speed);
        let end = ((ENDS / corner) as usize).min(position.len() / 4);
        let apart = ((1.0 / (ROWS_PER_CORNER * corner)) as usize).max(1);
        Self {
            spacing_s,
            corner,
            kept: [end, position.len() - end, apart],
            command: measured.command.clone(),
            position,
            speed,
            acceleration,
            is_check: measured.is_check,
        }
    }

    /// A series with a value per row, low-passed at the corner and decimated.
    pub(super) fn smooth(&self, series: &[f64]) -> Vec<f64> {
        self.thin(&low_pass(series, self.corner))
    }

    /// The command, changed row by row, low-passed at the corner.
    pub(super) fn command(&self, change: impl Fn(f64) -> f64) -> Vec<f64> {
        self.smooth(&self.command.iter().map(|u| change(*u)).collect::<Vec<f64>>())
    }

    /// The rows that are kept.
    pub(super) fn thin(&self, series: &[f64]) -> Vec<f64> {
        let [first, last, apart] = self.kept;
        series[first..last].iter().step_by(apart).copied().collect()
    }

    /// A function of position and speed at every row, low-passed at the corner.
    pub(super) fn of_motion(&self, f: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        low_pass(
            &self.position.iter().zip(&self.speed).map(|(x, v)| f(*x, *v)).collect::<Vec<f64>>(),
            self.corner,
        )
    }

    /// A series delayed by `late_s`, interpolated between rows; its ends are held.
    pub(super) fn shifted(&self, series: &[f64], late_s: f64) -> Vec<f64> {
        let rows = late_s / self.spacing_s;
        let last = series.len() - 1;
        (0..series.len())
            .map(|i| {
                let at = (i as f64 - rows).clamp(0.0, last as f64);
                let low = (at as usize).min(last.saturating_sub(1));
                series[low] + (at - low as f64) * (series[(low + 1).min(last)] - series[low])
            })
            .collect()
    }

    /// Slope of a series, per second.
    pub(super) fn rate(&self, series: &[f64]) -> Vec<f64> {
        slope(series).iter().map(|x| x / self.spacing_s).collect()
    }
}

/// Smooth sign of a speed about zero; `usual` is the root mean square speed.
pub(super) fn sign(speed: f64, usual: f64) -> f64 {
    (speed / (SIGN_SHARE * usual).max(f64::MIN_POSITIVE)).tanh()
}

pub(super) fn rms(series: &[f64]) -> f64 {
    (series.iter().map(|x| x * x).sum::<f64>() / series.len().max(1) as f64).sqrt()
}

/// A low-pass corner a few times above the motion of all experiments, Hz. The frequency of the motion is the
/// ratio of speed to excursion below the corner, iterated until it converges.
pub(super) fn corner_hz(records: &[Measured]) -> f64 {
    let of = |measured: &Measured| {
        let spacing_s = measured.spacing_s;
        let mut corner_hz = 0.2 / spacing_s;
        for _ in 0..ROUNDS {
            let position = low_pass(&measured.position, corner_hz * spacing_s);
            let mean = position.iter().sum::<f64>() / position.len().max(1) as f64;
            let excursion = rms(&position.iter().map(|x| x - mean).collect::<Vec<f64>>());
            let speed = rms(&slope(&position)) / spacing_s;
            let motion_hz = speed / excursion.max(f64::MIN_POSITIVE) / std::f64::consts::TAU;
            corner_hz = corner_hz.min(ABOVE_MOTION * motion_hz);
        }
        corner_hz
    };
    let mut corners: Vec<f64> = records.iter().map(of).collect();
    corners.sort_by(f64::total_cmp);
    corners.get(corners.len() / 2).copied().unwrap_or(1.0)
}
