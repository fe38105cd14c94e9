//! The static and delayed part of a sensor, applied to whole series: delay, gain, bias and quantisation.

use feeler_plant::assembly::SensorPart;

/// Noise-free readings of a filtered signal sampled every `spacing_s`, with quantisation if `quantised`.
pub(super) fn readings(sensor: &SensorPart, signal: &[f64], spacing_s: f64, quantised: bool) -> Vec<f64> {
    let rows = sensor.delay / spacing_s;
    let delayed: Vec<f64> = if rows > 0.0 {
        (0..signal.len()).map(|k| at(signal, k as f64 - rows)).collect()
    } else {
        signal.to_vec()
    };
    let resolutions: &[f64] = if quantised { &sensor.resolutions } else { &[] };
    delayed.into_iter().map(|x| reading(sensor, x, resolutions)).collect()
}

/// Reading of a sensor from its delayed and filtered signal, quantised with `steps`.
pub(super) fn reading(sensor: &SensorPart, signal: f64, steps: &[f64]) -> f64 {
    steps.iter().fold(sensor.gain * signal + sensor.bias, |reading, step| in_steps(reading, *step))
}

/// A value rounded to whole steps; unchanged if the step is zero.
pub(crate) fn in_steps(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}

/// A series between its rows: the cubic through four neighbours (Catmull and Rom). Before the start it has
/// its first value.
fn at(series: &[f64], row: f64) -> f64 {
    if row <= 0.0 {
        return series[0];
    }
    let i = (row.floor() as usize).min(series.len() - 1);
    let s = row - i as f64;
    let last = series.len() - 1;
    let [a, b, c, d] = [i.saturating_sub(1), i, i + 1, i + 2].map(|k| series[k.min(last)]);
    b + 0.5 * s * (c - a + s * (2.0 * a - 5.0 * b + 4.0 * c - d + s * (3.0 * (b - c) + d - a)))
}
