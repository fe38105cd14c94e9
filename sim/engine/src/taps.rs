//! Delayed readings: the signal as it was.

use std::collections::VecDeque;

use feeler_lanes::Lane;

use crate::clock::due;

/// Somebody who reads a delayed sensor at instants known in advance: the signal is taken `delay` earlier, exactly then.
#[derive(Clone, Debug)]
pub(crate) struct Tap<L> {
    pub(crate) signal: usize,
    pub(crate) delay_s: f64,
    taken: VecDeque<L>,
    /// When to take the signal next.
    pub(crate) next_s: f64,
    /// Readings whose signal has been taken so far.
    pub(crate) count: u64,
}

impl<L: Lane> Tap<L> {
    /// A tap whose first reading is at `first_s`.
    pub(crate) fn new(signal: usize, delay_s: f64, first_s: f64) -> Self {
        Self { signal, delay_s, taken: VecDeque::new(), next_s: (first_s - delay_s).max(0.0), count: 0 }
    }

    /// Takes the signal for every reading that is due at `t_s`; `instant_of(k)` is when reading `k` happens. Before the start the signal is its initial one.
    pub(crate) fn take(&mut self, t_s: f64, value: L, instant_of: impl Fn(u64) -> f64) {
        while due(self.next_s, t_s) {
            self.taken.push_back(value);
            self.count += 1;
            self.next_s = (instant_of(self.count) - self.delay_s).max(0.0);
        }
    }

    /// The signal for the next reading.
    pub(crate) fn pop(&mut self) -> L {
        self.taken.pop_front().unwrap_or_else(L::zero)
    }
}
