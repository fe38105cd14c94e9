//! A zero-phase low-pass: a second-order Butterworth filter, applied once forward and once backward.

use std::f64::consts::{PI, SQRT_2};

/// Length of the mirrored stretch at each end of a record, in periods of the corner: the filter settles
/// there.
const SETTLING: f64 = 3.0;

/// Low-passes `series` at the frequency `corner`, cycles per row, below a half.
pub(crate) fn low_pass(series: &[f64], corner: f64) -> Vec<f64> {
    let n = series.len();
    if n < 4 || corner >= 0.45 {
        return series.to_vec();
    }
    let margin = ((SETTLING / corner) as usize).clamp(1, n - 1);
    // Mirrored through the end points, so that value and slope are continuous.
    let before = (1..=margin).rev().map(|i| 2.0 * series[0] - series[i]);
    let after = (1..=margin).map(|i| 2.0 * series[n - 1] - series[n - 1 - i]);
    let mut long: Vec<f64> = before.chain(series.iter().copied()).chain(after).collect();
    // With this corner of each pass, the two passes together attenuate by 3 dB at `corner`.
    let biquad = Biquad::new(corner / (SQRT_2 - 1.0).sqrt().sqrt());
    for _ in 0..2 {
        biquad.pass(&mut long);
        long.reverse();
    }
    long[margin..margin + n].to_vec()
}

struct Biquad {
    b: [f64; 3],
    a: [f64; 2],
}

impl Biquad {
    fn new(corner: f64) -> Self {
        let k = (PI * corner.min(0.49)).tan();
        let norm = 1.0 / (1.0 + SQRT_2 * k + k * k);
        let b = k * k * norm;
        Self { b: [b, 2.0 * b, b], a: [2.0 * (k * k - 1.0) * norm, (1.0 - SQRT_2 * k + k * k) * norm] }
    }

    fn pass(&self, series: &mut [f64]) {
        let first = series[0];
        let (mut x, mut y) = ([first; 2], [first; 2]);
        for value in series {
            let now = self.b[0] * *value + self.b[1] * x[0] + self.b[2] * x[1]
                - self.a[0] * y[0]
                - self.a[1] * y[1];
            (x, y) = ([*value, x[0]], [now, y[0]]);
            *value = now;
        }
    }
}

/// Slope of a series per row, by central differences over five rows (three or two near the ends).
pub(crate) fn slope(series: &[f64]) -> Vec<f64> {
    let n = series.len();
    (0..n)
        .map(|i| {
            if i >= 2 && i + 2 < n {
                return (8.0 * (series[i + 1] - series[i - 1]) - (series[i + 2] - series[i - 2])) / 12.0;
            }
            let (low, high) = (i.saturating_sub(1), (i + 1).min(n - 1));
            (series[high] - series[low]) / (high - low).max(1) as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gain(frequency: f64, corner: f64) -> [f64; 2] {
        let wave = |phase: f64| (0..4000).map(move |k| (2.0 * PI * frequency * f64::from(k) + phase).cos());
        let series: Vec<f64> = wave(0.0).collect();
        let filtered = low_pass(&series, corner);
        let onto = |phase: f64| {
            let sum: f64 = filtered.iter().zip(wave(phase)).skip(1000).take(2000).map(|(a, b)| a * b).sum();
            sum / 1000.0
        };
        [onto(0.0), onto(-0.5 * PI)]
    }

    #[test]
    fn truth_the_corner_is_down_by_three_decibels_and_nothing_is_late() {
        // The compared stretch has a whole number of periods. The bilinear transform shifts frequencies by
        // less than a percent here.
        let [size, late] = gain(0.01, 0.01);
        assert!((size - 0.5_f64.sqrt()).abs() < 0.01 && late.abs() < 1e-6, "{size} {late}");
        let [size, _] = gain(0.001, 0.01);
        assert!((size - 1.0).abs() < 1e-3);
        // Two second-order passes attenuate by the fourth power of the frequency ratio.
        let [size, _] = gain(0.1, 0.01);
        assert!(size < 3e-4);
    }

    #[test]
    fn truth_a_line_stays_a_line() {
        let line: Vec<f64> = (0..300).map(|k| 2.0 + 0.1 * f64::from(k)).collect();
        let worst = low_pass(&line, 0.02).iter().zip(&line).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 0.02, "{worst}");
        assert!(slope(&line).iter().all(|s| (s - 0.1).abs() < 1e-12));
    }
}
