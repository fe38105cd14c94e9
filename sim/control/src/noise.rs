//! Random numbers that depend on an element and an instant.
//!
//! Each element draws from its own [`Stream`], keyed by the run's seed and the element's name. Adding a
//! sensor thus does not change another's noise. A stream is read at an index, not in sequence. A caller may
//! use the instant (in picoseconds) as the index. The noise then depends on sensor and instant only, whatever
//! the order or the number of readings.
//!
//! The generator is `ChaCha` with 8 rounds (Bernstein, "`ChaCha`, a variant of Salsa20", 2008), read at a
//! computed position: the same bits on every machine. Normal numbers use the platform's `ln`, `sin` and
//! `cos`, whose last bit may differ between platforms.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Separates the keys of this project from other uses of the generator, and versions the layout below.
const DOMAIN: u64 = u64::from_le_bytes(*b"feeler-1");

/// 32-bit words per index: four for a pair of normals, two for a uniform, two spare for block alignment.
const WORDS_PER_INDEX: u128 = 8;

/// Words of an index before its uniform number.
const WORDS_BEFORE_UNIFORM: u128 = 4;

/// The random numbers of one element.
#[derive(Clone, Debug)]
pub struct Stream {
    key: [u8; 32],
}

impl Stream {
    /// The stream of element `name` (its full key, such as `sensors.force`) in a run with `seed`.
    pub fn new(seed: u64, name: &str) -> Self {
        let mut key = [0; 32];
        for (bytes, word) in key.chunks_exact_mut(8).zip([seed, fnv1a(name), name.len() as u64, DOMAIN]) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        Self { key }
    }

    /// The standard normal number at `index`: mean 0, variance 1.
    pub fn normal_at(&self, index: u64) -> f64 {
        let mut generator = self.at(index, 0);
        normal_pair(generator.next_u64(), generator.next_u64())[0]
    }

    /// The uniform number at `index`, in `[0, 1)`; independent of [`Self::normal_at`] at the same index.
    pub fn uniform_at(&self, index: u64) -> f64 {
        unit_interval(self.at(index, WORDS_BEFORE_UNIFORM).next_u64())
    }

    /// Two independent standard normal numbers for each of `N` indices from `first` on; the first of each
    /// pair is [`Self::normal_at`].
    pub fn normal_pairs_from<const N: usize>(&self, first: u64) -> [[f64; 2]; N] {
        let mut generator = self.at(first, 0);
        std::array::from_fn(|_| {
            let pair = normal_pair(generator.next_u64(), generator.next_u64());
            // The uniform number and the spare words of this index.
            generator.next_u64();
            generator.next_u64();
            pair
        })
    }

    fn at(&self, index: u64, word: u128) -> ChaCha8Rng {
        let mut generator = ChaCha8Rng::from_seed(self.key);
        generator.set_word_pos(u128::from(index) * WORDS_PER_INDEX + word);
        generator
    }
}

/// Fowler, Noll and Vo's hash, variant 1a, 64 bits: portable, and sufficient to distinguish the names of one
/// machine.
fn fnv1a(name: &str) -> u64 {
    name.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The top 53 bits as a number in `[0, 1)`.
fn unit_interval(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
}

/// Box and Muller's transform of two uniform numbers (Ann. Math. Statist. 29, 1958).
fn normal_pair(bits_a: u64, bits_b: u64) -> [f64; 2] {
    // In (0, 1], so that the logarithm is finite.
    let radius = (-2.0 * (1.0 - unit_interval(bits_a)).ln()).sqrt();
    let (sin, cos) = (TAU * unit_interval(bits_b)).sin_cos();
    [radius * cos, radius * sin]
}
