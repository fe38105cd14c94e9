//! Noise of a channel without a stated noise, from the scatter of its readings.
//!
//! Differences of a high order remove a motion and leave white noise. They multiply the variance of noise by
//! a binomial coefficient (Gasser, Sroka and Jennen-Steinmetz 1986; Hall, Kay and Titterington 1990).
//! Low-passed noise is not fully visible, so the result is a lower bound.

use super::data::Record;

/// Order of the differences. At an eighth of the sampling rate they reduce a motion to a thousandth, so that
/// only noise and impacts remain.
const ORDER: usize = 8;
/// Binomial coefficient of twice this order over the order: the factor by which the differences multiply the
/// variance of white noise.
const GAIN: f64 = 12870.0;
/// Ratio of a normal distribution's standard deviation to its median absolute value. A median ignores the few
/// rows of an impact.
const SIGMA_OVER_MEDIAN: f64 = 1.4826;

/// White noise has the same scatter in every other row as in all rows. A command that holds its values has
/// less scatter there: beyond this ratio it is not noise.
const HELD: f64 = 1.25;
/// A smooth command has far more scatter in every other row: up to 256 times more. Beyond this ratio the
/// scatter is not noise. Below it a smooth part is at most some percent of the noise.
const SMOOTH: f64 = 3.0;
/// Scatter of more than this share of a command (root mean square) belongs to the command.
const MOST_NOISE: f64 = 0.3;

/// Largest relative deviation of the rows that a difference spans from their usual number.
const UNEVEN: f64 = 0.05;

/// Standard deviation of white noise in a command; zero if the scatter belongs to the command.
pub(crate) fn noise_of_command(command: &[f64]) -> f64 {
    let every_other: Vec<f64> = command.iter().step_by(2).copied().collect();
    let [all, other] = [command, &every_other].map(of_command);
    let is_noise = other < SMOOTH * all && all < HELD * other && all < MOST_NOISE * rms(command);
    if is_noise { all } else { 0.0 }
}

/// Root mean square of a series.
pub(crate) fn rms(series: &[f64]) -> f64 {
    (series.iter().map(|u| u * u).sum::<f64>() / series.len().max(1) as f64).sqrt()
}

/// Scatter of a command as white noise: the least of several orders. A low order sees less of the jumps that
/// friction leaves in a command at every reversal, a high order less of the motion.
fn of_command(command: &[f64]) -> f64 {
    [(3, 20.0), (5, 252.0), (ORDER, GAIN)]
        .into_iter()
        .map(|(order, gain)| middle(sizes(command, order), gain))
        .fold(f64::INFINITY, f64::min)
}

/// Standard deviation of white noise in the readings of a channel. Differences across bridged rows are
/// excluded, unless the channel is read at a regular interval.
pub(crate) fn of_readings(record: &Record, channel: usize) -> f64 {
    let rows: Vec<usize> = record.read_rows(channel).collect();
    let spans: Vec<usize> = rows.windows(ORDER + 1).map(|rows| rows[ORDER] - rows[0]).collect();
    let mut sorted = spans.clone();
    sorted.sort_unstable();
    let usual = sorted.get(sorted.len() / 2).map_or(0.0, |span| *span as f64);
    let kept = sizes(&record.readings(channel), ORDER).into_iter().zip(spans);
    let even = kept.filter(|(_, span)| *span as f64 <= (1.0 + UNEVEN) * usual);
    middle(even.map(|(size, _)| size).collect(), GAIN)
}

/// Absolute values of the differences of an order along a series.
fn sizes(series: &[f64], order: usize) -> Vec<f64> {
    let mut differences = series.to_vec();
    for _ in 0..order {
        differences = differences.windows(2).map(|pair| pair[1] - pair[0]).collect();
    }
    differences.into_iter().map(f64::abs).collect()
}

fn middle(mut sizes: Vec<f64>, gain: f64) -> f64 {
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 2).map_or(0.0, |middle| SIGMA_OVER_MEDIAN * middle / gain.sqrt())
}

/// Standard deviation of white noise in a channel, from its readings in all experiments. It is the median
/// over the experiments, so that neither a filtered experiment nor one with impacts decides.
pub(super) fn of_channel(records: &[Record], channel: usize) -> f64 {
    usual(records.iter().map(|record| of_readings(record, channel)))
}

/// Standard deviation of white noise in the commands of a drive: the median over the experiments.
pub(super) fn of_drive(records: &[Record], drive: usize) -> f64 {
    usual(records.iter().map(|record| noise_of_command(&record.commands[drive])))
}

fn usual(noises: impl Iterator<Item = f64>) -> f64 {
    let mut noises: Vec<f64> = noises.collect();
    noises.sort_by(f64::total_cmp);
    noises.get(noises.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::chance::Chance;
    use crate::dataset::bridge::bridge;

    const SIGMA: f64 = 0.02;

    /// A motion of unit size up to an eighth of the sampling rate, with uniform noise and an impact.
    fn noisy(sigma: f64) -> Vec<f64> {
        let mut chance = Chance::seeded(5);
        let at = |k: usize| {
            (0.01 * k as f64).sin()
                + 0.1 * (0.7 * k as f64).sin()
                + if (900..905).contains(&k) { 30.0 } else { 0.0 }
        };
        (0..4000).map(|k| at(k) + sigma * chance.deviate()).collect()
    }

    fn record(series: Vec<f64>, gaps: Vec<bool>) -> Record {
        Record { series: vec![series], bridged: vec![gaps], ..Record::default() }
    }

    /// Noise of a channel that is read in every fifth row and interpolated between, or with two of fifty rows
    /// bridged.
    #[test]
    fn truth_bridged_rows_do_not_hide_noise() {
        let noise: Vec<f64> = noisy(SIGMA).iter().zip(noisy(0.0)).map(|(a, b)| a - b).collect();
        for is_gap in [|k: usize| !k.is_multiple_of(5), |k: usize| k % 50 < 2] {
            let gaps: Vec<bool> = (0..noise.len()).map(is_gap).collect();
            let mut series = noise.clone();
            bridge(&mut series, is_gap, false);
            // About 800 differences in the first case; neighbouring ones share rows.
            let found = of_readings(&record(series.clone(), gaps), 0);
            assert!((found / SIGMA - 1.0).abs() < 0.2, "{found}");
            assert!(of_command(&series) < 0.99 * found);
        }
    }

    #[test]
    fn truth_noise_of_a_command_is_told_from_its_steps() {
        let mut chance = Chance::default();
        let noisy: Vec<f64> =
            (0..4000).map(|k| (0.01 * f64::from(k)).sin() + 0.02 * chance.deviate()).collect();
        // Neighbouring differences share rows, so that 4000 of them give the median to about four percent.
        assert!((noise_of_command(&noisy) / 0.02 - 1.0).abs() < 0.1);
        let held: Vec<f64> = (0..4000).map(|k| (0.9 * f64::from(k / 2)).sin()).collect();
        assert!(noise_of_command(&held) == 0.0, "{}", noise_of_command(&held));
        let clean: Vec<f64> = (0..4000).map(|k| (0.3 * f64::from(k)).sin()).collect();
        assert!(noise_of_command(&clean) < 1e-3);
        // A command may itself be as rough as noise.
        let asked: Vec<f64> = (0..4000).map(|_| chance.deviate()).collect();
        assert!(noise_of_command(&asked) == 0.0);
    }

    #[test]
    fn truth_scatter_is_the_noise_and_not_the_motion() {
        // Neighbouring differences share rows, so 4000 of them give the median to about four per cent.
        assert!((of_command(&noisy(SIGMA)) / SIGMA - 1.0).abs() < 0.1);
        // A motion of amplitude 0.1 at 0.7 radians per row looks like noise of 0.1 (2 sin 0.35)^8 /
        // sqrt(12870).
        assert!(of_command(&noisy(0.0)) < 1e-4);
        let records = [SIGMA, 0.0, 2.0 * SIGMA].map(|sigma| record(noisy(sigma), Vec::new()));
        assert!((of_channel(&records, 0) / SIGMA - 1.0).abs() < 0.1);
        assert!(of_command(&[1.0; 4]).abs() < f64::EPSILON);
    }

    /// A command at 40 rows a period that friction makes jump in every twentieth row.
    #[test]
    fn truth_jumps_at_reversals_are_no_noise_of_a_command() {
        let mut chance = Chance::seeded(5);
        let smooth = |k: usize| (0.05 * PI * k as f64).sin();
        let command: Vec<f64> =
            (0..4000).map(|k| smooth(k) + 3.0 * smooth(k + 10).signum() + SIGMA * chance.deviate()).collect();
        let of_order = |order, gain| middle(sizes(&command, order), gain);
        assert!(of_order(ORDER, GAIN) > 1.5 * SIGMA, "{}", of_order(ORDER, GAIN));
        assert!(of_command(&command) < 1.4 * SIGMA, "{}", of_command(&command));
    }
}
