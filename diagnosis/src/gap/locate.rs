//! Location of the gap: by channel, frequency band, phase of the motion and amplitude.

use feeler_plant::description::Engagement;
use rayon::prelude::*;
use std::collections::BTreeMap;

use crate::dataset::Record;
use crate::fit::least_squares::Task;
use crate::fit::missing::low_pass;
use crate::fit::model::Model;
use crate::predict::Prediction;
use crate::report::GapCell;

/// Edges of the bands, Hz; the last band ends at half the sampling rate.
const EDGES_HZ: [f64; 4] = [5.0, 20.0, 80.0, 320.0];
/// Time before touch-down that counts as approach, s.
const APPROACH_S: f64 = 0.1;
/// Time after touch-down that counts as impact, and after lift-off as release, s.
const IMPACT_S: f64 = 0.02;
/// Limits of low and high amplitude: ratio of an experiment's command to the median of similar experiments.
const AMPLITUDE_SHARES: [f64; 2] = [0.8, 1.25];

const PHASES: [&str; 5] = ["free", "approach", "impact", "contact", "release"];
const AMPLITUDES: [&str; 3] = ["low", "middle", "high"];

/// A model with values of its unknowns.
pub(crate) type At<'a> = (&'a Model, &'a [f64]);

#[derive(Clone, Copy, Default)]
struct Sums {
    squares: [f64; 3],
    floor: f64,
    rows: f64,
    seconds: f64,
}

/// The table of the gap before calibration, after it and with the accepted effects, over all experiments.
/// `noise` is the standard deviation of every channel.
pub(crate) fn table(task: &Task<'_>, models: [At<'_>; 3], noise: &[f64]) -> Vec<GapCell> {
    let dataset = task.dataset;
    let levels: Vec<f64> = dataset.records.iter().map(level).collect();
    let parts: Vec<BTreeMap<[usize; 4], Sums>> = (0..dataset.records.len())
        .into_par_iter()
        .map(|r| {
            let predictions: Option<Vec<Prediction>> =
                models.iter().map(|(model, theta)| task.predict(model, theta, r)).collect();
            predictions.map_or_else(BTreeMap::new, |predictions| {
                of_record(task, r, &predictions, noise, amplitude(task, r, &levels))
            })
        })
        .collect();
    let mut sums: BTreeMap<[usize; 4], Sums> = BTreeMap::new();
    for (key, part) in parts.into_iter().flatten() {
        let sum = sums.entry(key).or_default();
        for (sum, part) in sum.squares.iter_mut().zip(part.squares) {
            *sum += part;
        }
        sum.floor += part.floor;
        sum.rows += part.rows;
        sum.seconds += part.seconds;
    }
    let bands = bands(&dataset.records);
    sums.into_iter()
        .map(|([c, band, phase, amplitude], sum)| {
            let mean = |square: f64| (square / sum.rows).sqrt();
            GapCell {
                channel: dataset.channels[c].column.clone(),
                band_hz: bands[band],
                phase: PHASES[phase],
                amplitude: AMPLITUDES[amplitude],
                before: mean(sum.squares[0]),
                refit: mean(sum.squares[1]),
                after: mean(sum.squares[2]),
                floor: mean(sum.floor),
                seconds: sum.seconds,
            }
        })
        .collect()
}

/// The bands of all records. Their edges are below half the slowest sampling rate, and the last band ends at
/// half the fastest. The spacings of records may differ in their last digits.
fn bands(records: &[Record]) -> Vec<[f64; 2]> {
    let half_rate = |record: &Record| 0.5 / record.spacing_s;
    let slowest = records.iter().map(half_rate).fold(f64::INFINITY, f64::min);
    let end = records.iter().map(half_rate).fold(0.0, f64::max);
    let edges: Vec<f64> = [0.0]
        .into_iter()
        .chain(EDGES_HZ.into_iter().filter(|edge| *edge < 0.8 * slowest))
        .chain([end])
        .collect();
    edges.windows(2).map(|w| [w[0], w[1]]).collect()
}

fn of_record(
    task: &Task<'_>,
    r: usize,
    predictions: &[Prediction],
    noise: &[f64],
    amplitude: usize,
) -> BTreeMap<[usize; 4], Sums> {
    let record = &task.dataset.records[r];
    let phases = phases(record, &predictions[1].touching);
    let bands = bands(&task.dataset.records);
    let half_rate = 0.5 / record.spacing_s;
    let mut sums: BTreeMap<[usize; 4], Sums> = BTreeMap::new();
    for (c, noise) in noise.iter().enumerate() {
        let scale = task.weights.scale[r][c].max(f64::MIN_POSITIVE);
        let noise = (noise / scale).powi(2);
        for (m, prediction) in predictions.iter().enumerate() {
            let residual: Vec<f64> =
                record.residual(c, &prediction.series[c]).into_iter().map(|x| x / scale).collect();
            for (band, part) in split(&residual, &bands, record.spacing_s).iter().enumerate() {
                let share = (bands[band][1].min(half_rate) - bands[band][0]) * 2.0 * record.spacing_s;
                for (&phase, x) in phases.iter().zip(part) {
                    let sum = sums.entry([c, band, phase, amplitude]).or_default();
                    sum.squares[m] += x * x;
                    if m == 0 {
                        sum.floor += noise * share;
                        sum.rows += 1.0;
                    }
                }
            }
        }
    }
    for sum in sums.values_mut() {
        sum.seconds = sum.rows * record.spacing_s;
    }
    sums
}

/// Splits a series into bands without phase shift; the bands add up to the series.
fn split(series: &[f64], bands: &[[f64; 2]], spacing_s: f64) -> Vec<Vec<f64>> {
    let mut below = vec![0.0; series.len()];
    let mut parts = Vec::new();
    for (i, band) in bands.iter().enumerate() {
        let low = if i + 1 == bands.len() { series.to_vec() } else { low_pass(series, band[1], spacing_s) };
        parts.push(low.iter().zip(&below).map(|(a, b)| a - b).collect());
        below = low;
    }
    parts
}

fn phases(record: &Record, touching: &[bool]) -> Vec<usize> {
    let n = touching.len();
    match record.engagement {
        Some(Engagement::Free) => return vec![0; n],
        Some(Engagement::Clamped) => return vec![3; n],
        _ => {}
    }
    let rows = |seconds: f64| (seconds / record.spacing_s).round() as usize;
    let mut out: Vec<usize> = touching.iter().map(|&t| if t { 3 } else { 0 }).collect();
    for k in 1..n {
        if touching[k] && !touching[k - 1] {
            (k..n.min(k + rows(IMPACT_S))).filter(|&i| touching[i]).for_each(|i| out[i] = 2);
            (k.saturating_sub(rows(APPROACH_S))..k).filter(|&i| !touching[i]).for_each(|i| out[i] = 1);
        }
        if !touching[k] && touching[k - 1] {
            (k..n.min(k + rows(IMPACT_S))).filter(|&i| !touching[i]).for_each(|i| out[i] = 4);
        }
    }
    out
}

fn level(record: &Record) -> f64 {
    let squares: f64 = record.commands.iter().flatten().map(|u| u * u).sum();
    (squares / record.len().max(1) as f64).sqrt()
}

fn amplitude(task: &Task<'_>, r: usize, levels: &[f64]) -> usize {
    let records = &task.dataset.records;
    let mut peers: Vec<f64> = (0..records.len())
        .filter(|&i| records[i].engagement == records[r].engagement)
        .map(|i| levels[i])
        .collect();
    peers.sort_by(f64::total_cmp);
    let share = levels[r] / peers[peers.len() / 2].max(f64::MIN_POSITIVE);
    AMPLITUDE_SHARES.iter().filter(|&&edge| share > edge).count()
}

/// Band and phase with the largest part of a channel's gap after calibration.
pub(crate) fn heart(cells: &[GapCell], channel: &str) -> Option<([f64; 2], &'static str)> {
    let mut bands: Vec<([f64; 2], f64)> = Vec::new();
    let mut phases = [0.0; PHASES.len()];
    for cell in cells.iter().filter(|cell| cell.channel == channel) {
        let excess = (cell.refit.powi(2) - cell.floor.powi(2)).max(0.0) * cell.seconds;
        match bands.iter_mut().find(|(band, _)| band[0].to_bits() == cell.band_hz[0].to_bits()) {
            Some((_, sum)) => *sum += excess,
            None => bands.push((cell.band_hz, excess)),
        }
        if let Some(phase) = PHASES.iter().position(|name| *name == cell.phase) {
            phases[phase] += excess;
        }
    }
    let band = bands.iter().max_by(|a, b| a.1.total_cmp(&b.1))?.0;
    let phase = (0..PHASES.len()).max_by(|&a, &b| phases[a].total_cmp(&phases[b]))?;
    Some((band, PHASES[phase]))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Rounding error of sums with a few hundred terms.
    const ROUNDING: f64 = 1e-12;

    fn sampled_every(spacing_s: f64) -> Record {
        Record::even("free.csv", spacing_s, Vec::new(), Vec::new())
    }

    /// At 200 Hz the last edge is exactly at the limit of 0.8 times half the rate. The last digits of the
    /// spacing would decide whether it counts.
    #[test]
    fn regress_records_whose_spacings_differ_in_their_last_digits_share_their_bands() {
        let [short, long] = [sampled_every(0.005 - 1e-12), sampled_every(0.005 + 1e-12)];
        assert_eq!(bands(&[short.clone(), long.clone()]).len(), bands(&[long, short]).len());
    }

    #[test]
    fn truth_bands_add_up_and_a_slow_sine_is_in_the_lowest() {
        let dt = 5e-4;
        let series: Vec<f64> = (0..4000).map(|k| (TAU * 1.0 * f64::from(k) * dt).sin()).collect();
        let parts = split(&series, &bands(&[sampled_every(dt)]), dt);
        for (k, x) in series.iter().enumerate() {
            assert!((parts.iter().map(|part| part[k]).sum::<f64>() - x).abs() < ROUNDING);
        }
        let power = |part: &[f64]| part.iter().map(|x| x * x).sum::<f64>();
        // A first-order filter applied twice at 5 Hz reduces 1 Hz by 1 / (1 + 1/25): 92 % of the power
        // remains.
        assert!(power(&parts[0]) > 0.9 * power(&series));
    }
}
