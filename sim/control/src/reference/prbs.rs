//! The pseudo-random binary sequence.

use std::sync::Arc;

use crate::error::ControlError;
use crate::noise::Stream;

/// Instants closer than this to a jump of a reference count as after it, s. A sample computed as `k T` may be
/// a rounding below the instant in the file.
pub(super) const TIME_TOLERANCE_S: f64 = 1e-12;

/// Feedback taps per register length from [`MIN_ORDER`] on. Each set belongs to a primitive polynomial over
/// GF(2), so the sequence has the maximum length, `2^order - 1`. (The tests run each through its period.)
const TAPS: [&[u32]; 17] = [
    &[2, 1],
    &[3, 2],
    &[4, 3],
    &[5, 3],
    &[6, 5],
    &[7, 6],
    &[8, 6, 5, 4],
    &[9, 5],
    &[10, 7],
    &[11, 9],
    &[12, 6, 4, 1],
    &[13, 4, 3, 1],
    &[14, 5, 3, 1],
    &[15, 14],
    &[16, 15, 13, 4],
    &[17, 14],
    &[18, 11],
];

pub(super) const MIN_ORDER: u32 = 2;
pub(super) const MAX_ORDER: u32 = MIN_ORDER + TAPS.len() as u32 - 1;

/// Maximum-length sequence of a linear feedback shift register (Golomb, "Shift Register Sequences", 1967), as
/// `+-amplitude`.
#[derive(Clone, Debug)]
pub(super) struct Prbs {
    clock_period_s: f64,
    amplitude: f64,
    chips: Arc<[bool]>,
    /// Chips in a period.
    length: i64,
    /// Chip at t = 0.
    start: usize,
}

impl Prbs {
    pub(super) fn new(
        order: u32,
        clock_period_s: f64,
        amplitude: f64,
        stream: &Stream,
    ) -> Result<Self, ControlError> {
        let chips: Arc<[bool]> = sequence(order)?.into();
        let start = (stream.uniform_at(0) * chips.len() as f64) as usize;
        Ok(Self { clock_period_s, amplitude, chips, length: (1 << order) - 1, start })
    }

    pub(super) fn value(&self, t_s: f64) -> f64 {
        let chip = ((t_s + TIME_TOLERANCE_S) / self.clock_period_s).floor() as i64;
        let length = self.chips.len();
        let index = (chip.rem_euclid(self.length) as usize + self.start) % length;
        if self.chips[index] { self.amplitude } else { -self.amplitude }
    }
}

/// One period of the sequence, from a register full of ones.
fn sequence(order: u32) -> Result<Vec<bool>, ControlError> {
    let wrong_order = ControlError::PrbsOrder { order, min: MIN_ORDER, max: MAX_ORDER };
    let taps = order.checked_sub(MIN_ORDER).and_then(|row| TAPS.get(row as usize)).ok_or(wrong_order)?;
    let length = (1_u32 << order) - 1;
    let mut register = length;
    let chips = (0..length).map(|_| {
        let feedback = taps.iter().fold(0, |bit, tap| bit ^ (register >> (tap - 1))) & 1;
        let out = register >> (order - 1) & 1 == 1;
        register = (register << 1 | feedback) & length;
        out
    });
    Ok(chips.collect())
}

#[cfg(test)]
mod tests {
    use super::{MAX_ORDER, MIN_ORDER, sequence};

    /// In a maximum-length sequence every pattern of `order` chips except all zeros occurs exactly once per
    /// period.
    #[test]
    fn truth_every_order_has_the_greatest_length() {
        for order in MIN_ORDER..=MAX_ORDER {
            let chips = sequence(order).unwrap();
            let length = (1_usize << order) - 1;
            assert_eq!(chips.len(), length);
            let mut seen = vec![false; length + 1];
            let mut pattern = 0;
            for i in 0..length + order as usize - 1 {
                pattern = (pattern << 1 | usize::from(chips[i % length])) & length;
                if i + 1 >= order as usize {
                    assert!(!seen[pattern], "order {order} repeats before its period");
                    seen[pattern] = true;
                }
            }
            assert!(!seen[0], "order {order} has a run of zeros as long as its register");
        }
    }
}
