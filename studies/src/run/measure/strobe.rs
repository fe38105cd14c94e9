//! The state of a motion once in each cycle.
//!
//! Values at a surface that the motion crosses once per cycle form its Poincaré map (M. di Bernardo et al.,
//! "Piecewise-smooth Dynamical Systems", 2008). There is one value if every cycle repeats the last, two after
//! a period doubling, and many if no cycle repeats. If the tool leaves the workpiece, the surface is
//! touch-down. The force is still zero there, so it is read one controller sample later. This gives a map of
//! the same kind that grows with the speed of impact. If the tool stays in contact, the surface is the
//! maximum of the force in each cycle. A controlled motion without contact is read at its maxima, too.

use crate::run::measure::contact::{Interval, peak};

/// Smallest number of touch-downs in the tail to count cycles; with fewer the motion is one in contact.
const LEAST_TOUCHES: usize = 2;
/// Before the force counts as rising through its mean again, it must have been below the mean by this part of
/// its range. So ripple does not count as a cycle.
const HYSTERESIS: f64 = 0.1;

/// A contact's force, or a motion that touches nothing, and its record.
#[derive(Clone, Copy, Debug)]
pub(in crate::run) struct Strobe<'a> {
    pub(in crate::run) t_s: &'a [f64],
    pub(in crate::run) force_n: &'a [f64],
    /// Spans of contact.
    pub(in crate::run) contacts: &'a [Interval],
    /// The evaluated part of the record.
    pub(in crate::run) tail_s: [f64; 2],
    /// Time from touch-down to the reading of the force.
    pub(in crate::run) delay_s: f64,
}

impl Strobe<'_> {
    /// The force once per cycle, N, in order of time.
    pub(in crate::run) fn values_n(&self) -> Vec<f64> {
        let touches: Vec<Interval> =
            self.contacts.iter().filter(|interval| interval.start_s >= self.tail_s[0]).copied().collect();
        if touches.len() < LEAST_TOUCHES {
            return self.peaks_n();
        }
        let end_s = self.t_s.last().copied().unwrap_or(0.0);
        let read = touches
            .into_iter()
            .map(|contact| (contact.start_s + self.delay_s, contact))
            .filter(|(t_s, _)| *t_s <= end_s);
        read.map(|(t_s, contact)| self.force_at(t_s, contact)).collect()
    }

    /// The largest force between one rise through the mean and the next.
    fn peaks_n(&self) -> Vec<f64> {
        let first = self.t_s.partition_point(|&t| t < self.tail_s[0]);
        let force_n = &self.force_n[first..];
        let mean_n = force_n.iter().sum::<f64>() / force_n.len().max(1) as f64;
        let (low, high) = force_n
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &f| (low.min(f), high.max(f)));
        let armed_below_n = mean_n - HYSTERESIS * (high - low);
        let mut armed = false;
        let mut rises: Vec<usize> = Vec::new();
        for (row, pair) in self.force_n.windows(2).enumerate().skip(first) {
            armed |= pair[0] < armed_below_n;
            if armed && pair[0] <= mean_n && pair[1] > mean_n {
                armed = false;
                rises.push(row);
            }
        }
        // A peak is that of a force, from zero upwards; a motion may be below zero throughout.
        let floor_n = low.min(0.0);
        let largest = |cycle: &[usize]| {
            let rows = cycle[0]..cycle[1];
            let above: Vec<f64> = self.force_n[rows.clone()].iter().map(|force| force - floor_n).collect();
            floor_n + peak(&self.t_s[rows], &above).force_n
        };
        rises.windows(2).map(largest).collect()
    }

    /// The force at an instant: a cubic through the two rows on either side in the same contact, or a line if
    /// there are fewer. The position of rows within a cycle then has no effect.
    fn force_at(&self, t_s: f64, contact: Interval) -> f64 {
        let after = self.t_s.partition_point(|&row| row < t_s).clamp(1, self.t_s.len().max(2) - 1);
        let inside =
            |row: &usize| self.t_s.get(*row).is_some_and(|t| (contact.start_s..=contact.end_s).contains(t));
        let near: Vec<usize> = (after.saturating_sub(2)..after + 2).filter(inside).collect();
        let rows = if [after - 1, after].iter().all(|row| near.contains(row)) {
            near
        } else {
            vec![after - 1, after]
        };
        let weight = |&i: &usize| -> f64 {
            let others = rows.iter().filter(|&&j| j != i);
            others.map(|&j| (t_s - self.t_s[j]) / (self.t_s[i] - self.t_s[j])).product()
        };
        rows.iter().map(|i| weight(i) * self.force_n[*i]).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// A half sine of 30 ms in rows of 0.5 ms: a cubic through four rows errs by 3/128 (w h)^4 = 2e-7 of it.
    const CUBIC: f64 = 1e-6;
    /// A sine of 13.7 Hz in rows of 0.5 ms. The parabola through its peak errs by about (w h)^4 / 128 = 3e-8
    /// of it, its neighbours by less than 1e-4.
    const PARABOLA: f64 = 1e-4;

    fn contacts(touches_s: &[f64], contact_s: f64) -> Vec<Interval> {
        touches_s.iter().map(|&start_s| Interval { start_s, end_s: start_s + contact_s }).collect()
    }

    fn rows(seconds: f64) -> Vec<f64> {
        (0..=(seconds * 2e3) as u32).map(|i| f64::from(i) * 0.5e-3).collect()
    }

    /// Impacts of 40 N and 60 N in turn, at intervals that are not multiples of the row spacing.
    #[test]
    fn truth_a_doubled_period_is_two_values() {
        let touches: Vec<f64> = (0..20).map(|i| 0.1 + f64::from(i) * 0.041_237).collect();
        let t_s = rows(1.0);
        let force = |t: f64| {
            let found = touches.iter().enumerate().find(|(_, touch)| (**touch..**touch + 0.03).contains(&t));
            found.map_or(
                0.0,
                |(i, touch)| if i % 2 == 0 { 40.0 } else { 60.0 } * (PI * (t - touch) / 0.03).sin(),
            )
        };
        let force_n: Vec<f64> = t_s.iter().map(|&t| force(t)).collect();
        let contacts = contacts(&touches, 0.03);
        let values =
            Strobe { t_s: &t_s, force_n: &force_n, contacts: &contacts, tail_s: [0.2, 1.0], delay_s: 1e-3 }
                .values_n();
        assert_eq!(values.len(), 17);
        for (i, value) in values.iter().enumerate() {
            let expected = if i % 2 == 0 { 60.0 } else { 40.0 } * (PI / 30.0).sin();
            // The first row of a contact has no neighbour before it in the same contact: a parabola there.
            assert!((value / expected - 1.0).abs() < 1e3 * CUBIC, "{value} {expected}");
        }
    }

    /// 5 sin wt + A cos wt/2 has peaks near 5 + A / sqrt 2 and 5 - A / sqrt 2.
    #[test]
    fn truth_a_cycle_in_contact_is_read_at_its_peaks() {
        let t_s = rows(2.0);
        let w = TAU * 13.7;
        let contacts = contacts(&[0.0], 2.0);
        let values = |a: f64| {
            let force_n: Vec<f64> =
                t_s.iter().map(|t| 20.0 + 5.0 * (w * t).sin() + a * (0.5 * w * t).cos()).collect();
            Strobe { t_s: &t_s, force_n: &force_n, contacts: &contacts, tail_s: [1.0, 2.0], delay_s: 1e-3 }
                .values_n()
        };
        let spread = |values: &[f64], step: usize| {
            values.windows(step + 1).map(|pair| (pair[step] - pair[0]).abs()).fold(0.0, f64::max)
        };
        let (single, doubled) = (values(0.0), values(2.0));
        assert!((12..=13).contains(&single.len()), "{single:?}");
        assert!(single.iter().all(|value| (value / 25.0 - 1.0).abs() < PARABOLA), "{single:?}");
        assert!(spread(&doubled, 2) < 25.0 * PARABOLA && spread(&doubled, 1) > 2.0, "{doubled:?}");
    }
}
