//! Tests whether an oscillation grows or decays, however slowly.
//!
//! The record is divided into windows of several cycles. The amplitude of each is the root mean square about
//! the mean, weighted by a Hann window. Incomplete cycles at the ends and the position of rows on a peak then
//! have no effect. A line through the logarithms of the amplitudes gives the rate of growth, and the scatter
//! about it gives its uncertainty.
//!
//! This assumes that windows scatter independently. The amplitude of a loop driven by noise wanders instead
//! from window to window, and a line fits parts of such a path well. The uncertainty of the rate then comes
//! from the spread of the rises between neighbouring windows.

use std::f64::consts::TAU;

use crate::run::measure::turns::turns;

/// Smallest number of cycles of a window: the effect of its ends is then below 0.2 % of the amplitude.
const CYCLES: usize = 3;
/// Smallest and largest number of windows.
const WINDOWS: [usize; 2] = [4, 24];
/// A slope is significant beyond this number of standard errors.
const SIGNIFICANT: f64 = 4.0;
/// Smaller growth or decay over the whole record counts as none.
const LEAST: f64 = 0.005;
/// Smallest number of windows of a wandering amplitude: three rises hardly show their spread.
const WINDOWS_IN_NOISE: usize = 8;
/// A trend continues if its later half is steeper than this share of its earlier one.
const GOES_ON: f64 = 0.5;

/// Change of the logarithm of an amplitude over a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::run) struct Trend {
    /// Change over the whole record, by the fitted line.
    pub(in crate::run) change: f64,
    /// Standard error of this change.
    error: f64,
    /// Changes by the earlier and by the later half, each extrapolated to the whole record.
    halves: [f64; 2],
}

impl Trend {
    /// The trend of evenly spaced values; `None` if there are too few cycles.
    pub(in crate::run) fn of(values: &[f64]) -> Option<Self> {
        Self::by(values, &|_| 0.0)
    }

    /// The trend of values driven by noise; with few cycles the error is unbounded.
    pub(in crate::run) fn in_noise(values: &[f64]) -> Option<Self> {
        Self::by(values, &|logs| {
            if logs.len() < WINDOWS_IN_NOISE { f64::INFINITY } else { random_walk_error(logs) }
        })
    }

    /// The trend with at least the error that `least_error` computes from the logarithms.
    fn by(values: &[f64], least_error: &dyn Fn(&[f64]) -> f64) -> Option<Self> {
        let count = (turns(values) / 2 / CYCLES).min(WINDOWS[1]);
        if count < WINDOWS[0] {
            return None;
        }
        // Windows have one of two lengths.
        let mut weights: Vec<Vec<f64>> = Vec::new();
        let mut logs = Vec::with_capacity(count);
        for i in 0..count {
            let window = &values[i * values.len() / count..(i + 1) * values.len() / count];
            let known = weights.iter().position(|weights| weights.len() == window.len());
            let own = known.unwrap_or_else(|| {
                weights.push(hann(window.len()));
                weights.len() - 1
            });
            logs.push(amplitude(window, &weights[own]).ln());
        }
        let (change, error) = line(&logs, count)?;
        let [(earlier, _), (later, _)] =
            [line(&logs[..count / 2], count)?, line(&logs[count - count / 2..], count)?];
        Some(Self { change, error: error.max(least_error(&logs)), halves: [earlier, later] })
    }

    /// Whether the amplitude falls.
    pub(in crate::run) fn falls(self) -> bool {
        self.change < 0.0 && self.is_significant()
    }

    pub(in crate::run) fn rises(self) -> bool {
        self.change > 0.0 && self.is_significant()
    }

    /// Whether it rises as fast at the end as before, so that no bound appears.
    pub(in crate::run) fn rises_on(self) -> bool {
        self.rises() && self.halves[1] > GOES_ON * self.halves[0]
    }

    /// Whether it falls as fast at the end as before, so that it will vanish.
    pub(in crate::run) fn falls_on(self) -> bool {
        self.falls() && self.halves[1] < GOES_ON * self.halves[0]
    }

    fn is_significant(self) -> bool {
        self.change.abs() > LEAST.max(SIGNIFICANT * self.error)
    }
}

/// The weights of a Hann window.
fn hann(count: usize) -> Vec<f64> {
    (0..count).map(|i| 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / count as f64).cos()).collect()
}

/// Root of the weighted mean square about the weighted mean.
fn amplitude(values: &[f64], weights: &[f64]) -> f64 {
    // The weights of a whole window add up to half their number.
    let mean_of = |of: &dyn Fn(f64) -> f64| {
        weights.iter().zip(values).map(|(w, v)| w * of(*v)).sum::<f64>() * 2.0 / values.len() as f64
    };
    let mean = mean_of(&|v| v);
    mean_of(&|v| (v - mean).powi(2)).sqrt()
}

/// The standard error of the change over all values, if each follows from the previous one by a random rise.
fn random_walk_error(values: &[f64]) -> f64 {
    let rises: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let n = rises.len() as f64;
    let mean = rises.iter().sum::<f64>() / n;
    let variance = rises.iter().map(|rise| (rise - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (variance / n).sqrt() * values.len() as f64
}

/// Slope per `whole` values of the line through equidistant values, and its standard error; `None` if some
/// value is NaN.
fn line(values: &[f64], whole: usize) -> Option<(f64, f64)> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let offset = |i: usize| (i as f64 - 0.5 * (n - 1.0)) / whole as f64;
    let spread: f64 = (0..values.len()).map(|i| offset(i).powi(2)).sum();
    let slope = values.iter().enumerate().map(|(i, v)| offset(i) * (v - mean)).sum::<f64>() / spread;
    let left: f64 = values.iter().enumerate().map(|(i, v)| (v - mean - slope * offset(i)).powi(2)).sum();
    slope.is_finite().then(|| (slope, (left / (n - 2.0).max(1.0) / spread).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance of a rate: the ends of the windows cause up to 0.2 % of an amplitude, over a record of 40
    /// windows' cycles.
    const RATE: f64 = 0.005;

    fn oscillation(rate: f64, hz: f64) -> Vec<f64> {
        (0..2000)
            .map(|i| f64::from(i) * 5e-4)
            .map(|t| 20.0 + (rate * t).exp() * (TAU * hz * t).sin())
            .collect()
    }

    #[test]
    fn truth_the_rate_of_an_exponential_is_found() {
        for (rate, hz) in [(0.03, 60.0), (-0.03, 60.0), (1.5, 137.3), (-0.4, 24.7)] {
            let trend = Trend::of(&oscillation(rate, hz)).unwrap();
            assert!((trend.change - rate).abs() < RATE, "{rate}: {trend:?}");
            assert_eq!((trend.rises_on(), trend.falls()), (rate > 0.0, rate < 0.0), "{trend:?}");
        }
    }

    /// 400.3 Hz in rows of 2 kHz: the largest row of a cycle beats at 1.5 Hz, by 5 % of the amplitude.
    #[test]
    fn truth_a_steady_oscillation_has_no_trend_however_rows_fall_on_it() {
        for hz in [24.7, 60.0, 137.3, 400.3] {
            let trend = Trend::of(&oscillation(0.0, hz)).unwrap();
            assert!(!trend.rises() && !trend.falls(), "{hz}: {trend:?}");
        }
    }

    #[test]
    fn truth_growth_that_comes_to_an_end_is_told_from_growth_that_goes_on() {
        let bounded: Vec<f64> = (0..2000)
            .map(|i| f64::from(i) * 5e-4)
            .map(|t| (2.0 - (-4.0 * t).exp()) * (TAU * 80.0 * t).sin())
            .collect();
        let trend = Trend::of(&bounded).unwrap();
        assert!(trend.rises() && !trend.rises_on(), "{trend:?}");
        assert_eq!(Trend::of(&oscillation(0.5, 3.0)), None);
    }
}
