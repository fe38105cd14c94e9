//! A random permutation computed on demand, so that a Latin hypercube of any size needs no memory.

/// Rounds of the Feistel network; four make it a good permutation (Luby and Rackoff, "How to construct
/// pseudorandom permutations", 1988).
const ROUNDS: u64 = 4;

/// A permutation of `0..count`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Permutation {
    count: u64,
    key: u64,
    half_bits: u32,
}

impl Permutation {
    pub(super) fn new(count: u64, key: u64) -> Self {
        let bits = u64::BITS - count.saturating_sub(1).leading_zeros();
        Self { count, key, half_bits: bits.div_ceil(2).max(1) }
    }

    /// The place to which `index` goes.
    pub(super) fn at(self, index: u64) -> u64 {
        // Cycle walking until the value is in range: a permutation of the larger set restricts to one of the
        // smaller.
        let mut value = index;
        loop {
            value = self.network(value);
            if value < self.count {
                return value;
            }
        }
    }

    fn network(self, value: u64) -> u64 {
        let mask = (1 << self.half_bits) - 1;
        let (mut left, mut right) = (value >> self.half_bits, value & mask);
        for round in 0..ROUNDS {
            (left, right) = (right, left ^ (mixed(self.key ^ (round << 56) ^ right) & mask));
        }
        left << self.half_bits | right
    }
}

/// The finaliser of `SplitMix64` (Steele, Lea and Flood, 2014): every bit of the input reaches every bit of
/// the output.
fn mixed(value: u64) -> u64 {
    let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let value = (value ^ value >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ value >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ value >> 31
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn prop_every_value_is_met_once() {
        for count in [1, 2, 3, 7, 64, 1000] {
            for key in [0, 1, 0xdead_beef] {
                let permutation = Permutation::new(count, key);
                let images: HashSet<u64> = (0..count).map(|i| permutation.at(i)).collect();
                assert_eq!(images.len() as u64, count);
                assert!(images.iter().all(|image| *image < count));
            }
        }
    }

    #[test]
    fn prop_keys_give_different_orders() {
        let order = |key| (0..100).map(|i| Permutation::new(100, key).at(i)).collect::<Vec<_>>();
        assert_ne!(order(1), order(2));
    }
}
