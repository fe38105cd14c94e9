//! Elongation of a joint: the difference between readings at its two ends.
//!
//! Two sensors may read positions of one chain of bodies. Noise of the command, unmodelled friction before
//! the joint and errors of the motion shift both readings equally. Their difference is free of these errors,
//! and shows free play of a few encoder steps. The second position of a chain is therefore compared as its
//! difference from the first, and the first by itself. Together they keep all information, and a common error
//! counts once.
//!
//! Sensors may have different zeros, so the mean difference over a record carries no information.

use feeler_plant::assembly::{Assembly, assemble};
use feeler_plant::description::Quantity;

use crate::dataset::{Dataset, Record};
use crate::predict::chain;

/// Smallest ratio of the first sensor's number of readings to the second's for a difference.
const READ_TOGETHER: f64 = 0.9;

/// The reference channel from which another channel is subtracted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Against {
    pub(super) channel: usize,
    /// Ratio of the own reading to the reference's reading of the same motion.
    ratio: f64,
}

/// The reference of every channel of every record: the first position of its chain of bodies.
pub(super) fn against(dataset: &Dataset) -> Vec<Vec<Option<Against>>> {
    let Ok(assembly) = assemble(&dataset.machine) else {
        return vec![vec![None; dataset.channels.len()]; dataset.records.len()];
    };
    dataset.records.iter().map(|record| of_record(dataset, &assembly, record)).collect()
}

fn of_record(dataset: &Dataset, assembly: &Assembly, record: &Record) -> Vec<Option<Against>> {
    let channels = 0..dataset.channels.len();
    let position = |c: usize| {
        let (node, relative_to, quantity) = assembly.node_read(dataset.channels[c].source)?;
        (quantity == Quantity::Position && !record.silent[c]).then_some((node, relative_to))
    };
    let Some((first, (node, fixed))) = channels.clone().find_map(|c| Some((c, position(c)?))) else {
        return vec![None; channels.len()];
    };
    let joined = chain(assembly, node, fixed);
    let of = |c: usize| {
        let (other, relative_to) = position(c)?;
        let is_beside = c > first && relative_to == fixed && joined.contains(&other);
        let is_read = record.count(first) as f64 >= READ_TOGETHER * record.count(c) as f64;
        let [own, others] = [c, first].map(|c| dataset.channels[c].scale(assembly).0);
        (is_beside && is_read).then_some(Against { channel: first, ratio: own / others })
    };
    channels.map(of).collect()
}

impl Against {
    /// One series less the scaled reference series.
    pub(super) fn less(self, own: &[f64], other: &[f64]) -> Vec<f64> {
        own.iter().zip(other).map(|(own, other)| own - self.ratio * other).collect()
    }

    /// Noise of the difference, from the noise of every channel.
    pub(super) fn noise(self, own: f64, noise: &[f64]) -> f64 {
        own.hypot(self.ratio * noise[self.channel])
    }

    /// Root mean square of the variation of the measured difference.
    pub(super) fn variation(self, record: &Record, c: usize) -> f64 {
        let mut measured = self.less(&record.series[c], &record.series[self.channel]);
        self.centre(record, c, &mut measured);
        (measured.iter().map(|x| x * x).sum::<f64>() / record.count(c) as f64).sqrt()
    }

    /// Sets rows without both readings to zero.
    pub(super) fn blank(self, record: &Record, c: usize, values: &mut [f64]) {
        record.blank(c, values);
        record.blank(self.channel, values);
    }

    /// Subtracts the mean over the rows with both readings, and sets the others to zero.
    pub(super) fn centre(self, record: &Record, c: usize, values: &mut [f64]) {
        let mut read = vec![1.0; values.len()];
        self.blank(record, c, &mut read);
        let sum: f64 = values.iter().zip(&read).map(|(value, read)| value * read).sum();
        let mean = sum / read.iter().sum::<f64>().max(1.0);
        for value in values.iter_mut() {
            *value -= mean;
        }
        self.blank(record, c, values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two sensors of a common motion, with a joint that stretches between them. The second has twice the
    /// scale and another zero.
    #[test]
    fn truth_the_difference_has_the_stretch_and_not_the_motion() {
        let motion: Vec<f64> = (0..8).map(|k| f64::from(k * k)).collect();
        let stretch = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
        let second: Vec<f64> = motion.iter().zip(stretch).map(|(x, s)| 2.0 * (x + s) + 100.0).collect();
        let against = Against { channel: 0, ratio: 2.0 };
        let record = Record::even("a", 1e-3, vec![vec![0.0; 8]], vec![motion, second]);
        // Integers are exact.
        assert_eq!(against.variation(&record, 1).to_bits(), 2.0_f64.to_bits());
        // The first sensor lacks its last two readings, so the difference has six of eight rows.
        let mut gaps = vec![false; 8];
        gaps[6..].fill(true);
        let record = Record { bridged: vec![gaps, Vec::new()], ..record };
        let mut left = against.less(&record.series[1], &record.series[0]);
        against.centre(&record, 1, &mut left);
        assert_eq!(left, [2.0, -2.0, 2.0, -2.0, 2.0, -2.0, 0.0, 0.0]);
        // Noise of 3 and of 2 times 2.
        assert_eq!(against.noise(3.0, &[2.0, 3.0]).to_bits(), 5.0_f64.to_bits());
    }

    /// A motion over 300 steps of two encoders, and an elongation of up to 3.7 steps.
    #[test]
    fn truth_rounding_of_two_moving_readings_is_noise_of_their_difference() {
        let rows = 3000;
        let stretch = |k: u32| 3.7 * (0.0051 * f64::from(k)).sin();
        let motion = |k: u32| 300.0 * (0.0137 * f64::from(k)).sin();
        let first: Vec<f64> = (0..rows).map(|k| motion(k).round()).collect();
        let second: Vec<f64> = (0..rows).map(|k| (motion(k) + stretch(k)).round()).collect();
        let against = Against { channel: 0, ratio: 1.0 };
        let left = against.less(&second, &first);
        let square: f64 = (0..rows).zip(&left).map(|(k, left)| (left - stretch(k)).powi(2)).sum();
        let step = 12.0_f64.sqrt().recip();
        let noise = against.noise(step, &[step]);
        // Near a reversal the motion stays within a step for some rows, which changes the noise by a few
        // percent.
        assert!(((square / f64::from(rows)).sqrt() / noise - 1.0).abs() < 0.05);
    }
}
