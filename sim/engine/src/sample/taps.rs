//! Delayed readings: past values of a signal.

use std::collections::VecDeque;

use feeler_lanes::Lane;

use crate::sample::clock::due;

/// A reader of a delayed sensor at instants known in advance: the signal is taken exactly `delay` earlier.
#[derive(Clone, Debug)]
pub struct Tap<L> {
    pub signal: usize,
    /// Time between the signal and its reading, s.
    pub delay_s: f64,
    /// The initial signal, and the number of remaining readings of it: those that refer to times before the
    /// start.
    initial: L,
    initial_left: u64,
    taken: VecDeque<L>,
    pub next_s: f64,
    /// Time of the signal after the next one, s; not later than `next_s` before the first signal is taken.
    pub(crate) after_s: f64,
    /// Readings whose signal has been taken so far.
    count: u64,
}

impl<L: Lane> Tap<L> {
    /// A tap whose first reading is at `first_s`.
    pub fn new(signal: usize, delay_s: f64, first_s: f64) -> Self {
        let next_s = (first_s - delay_s).max(0.0);
        Self {
            signal,
            delay_s,
            initial: L::zero(),
            initial_left: 0,
            taken: VecDeque::new(),
            next_s,
            after_s: next_s,
            count: 0,
        }
    }

    /// Takes the signal for every reading that needs it at `t_s`; `instant_of(k)` is the time of reading `k`.
    /// Before the start the signal has its initial value.
    #[inline(always)]
    pub fn take(&mut self, t_s: f64, value: L, instant_of: impl Fn(u64) -> f64) {
        // Half of the instants at which it is asked are those of the reading itself.
        if !due(self.next_s, t_s) {
            return;
        }
        let before = self.count;
        if self.count == 0 && due(self.next_s, 0.0) {
            self.initial = value;
            self.count = first_after(self.delay_s, &instant_of);
            self.initial_left = self.count;
            self.next_s = instant_of(self.count) - self.delay_s;
        }
        while due(self.next_s, t_s) {
            self.taken.push_back(value);
            self.count += 1;
            self.next_s = instant_of(self.count) - self.delay_s;
        }
        if self.count != before {
            self.after_s = instant_of(self.count + 1) - self.delay_s;
        }
    }

    /// The signal for the next reading.
    #[inline(always)]
    pub fn pop(&mut self) -> L {
        if self.initial_left > 0 {
            self.initial_left -= 1;
            return self.initial;
        }
        self.taken.pop_front().unwrap_or_else(L::zero)
    }
}

/// The first reading later than `delay_s`. A delay may span more readings than could be counted singly.
fn first_after(delay_s: f64, instant_of: impl Fn(u64) -> f64) -> u64 {
    let early = |k: u64| due(instant_of(k), delay_s);
    let mut above = 1;
    while early(above) && above < u64::MAX / 2 {
        above *= 2;
    }
    let mut below = 0;
    while above - below > 1 {
        let middle = below + (above - below) / 2;
        if early(middle) { below = middle } else { above = middle }
    }
    if early(below) { above } else { below }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::float_cmp, reason = "readings are handed through unchanged")]
    fn truth_readings_before_the_start_get_the_initial_value_however_many_they_are() {
        let mut tap = Tap::<f64>::new(0, 1e9, 0.0);
        tap.take(0.0, 3.0, |k| k as f64 * 1e-3);
        assert_eq!(tap.count, 1_000_000_000_001);
        assert!(tap.taken.is_empty());
        assert_eq!(tap.pop(), 3.0);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "readings are handed through unchanged")]
    fn truth_a_delay_of_two_and_a_half_periods_takes_between_readings() {
        let mut tap = Tap::<f64>::new(0, 2.5, 0.0);
        tap.take(0.0, 7.0, |k| k as f64);
        assert_eq!(tap.next_s, 0.5);
        tap.take(0.5, 8.0, |k| k as f64);
        let readings: Vec<f64> = (0..4).map(|_| tap.pop()).collect();
        assert_eq!(readings, [7.0, 7.0, 7.0, 8.0]);
    }
}
