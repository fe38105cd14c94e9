//! Random numbers that depend on an element and an instant.
//!
//! Each element draws from its own [`Stream`], keyed by the run's seed and the element's name. Adding a
//! sensor thus does not change another's noise. A stream is read at an index, not in sequence. A caller may
//! use the instant (in picoseconds) as the index. The noise then depends on sensor and instant only, whatever
//! the order or the number of readings.
//!
//! The generator is `ChaCha` with 8 rounds (Bernstein, "`ChaCha`, a variant of Salsa20", 2008), read at a
//! computed position: the same bits on every machine. Several positions are computed side by side, which
//! generators that count on from one position do not offer. Normal numbers use the platform's `ln`, `sin` and
//! `cos`, whose last bit may differ between platforms.

use std::f64::consts::TAU;

use feeler_lanes::dispatch;

/// Separates the keys of this project from other uses of the generator, and versions the layout below.
const DOMAIN: u64 = u64::from_le_bytes(*b"feeler-1");

/// "expand 32-byte k", with which a block begins.
const WORDS: [u32; 4] = [0x6170_7865, 0x3320_646e, 0x7962_2d32, 0x6b20_6574];

/// Positions whose blocks are computed side by side: one AVX2 register of words.
const ABREAST: usize = 8;

/// The random numbers of one element.
#[derive(Clone, Debug)]
pub struct Stream {
    key: [u32; 8],
}

impl Stream {
    /// The stream of element `name` (its full key, such as `sensors.force`) in a run with `seed`.
    pub fn new(seed: u64, name: &str) -> Self {
        let mut key = [0; 8];
        for (words, long) in key.chunks_exact_mut(2).zip([seed, fnv1a(name), name.len() as u64, DOMAIN]) {
            words.copy_from_slice(&[long as u32, (long >> 32) as u32]);
        }
        Self { key }
    }

    /// The standard normal number at `index`: mean 0, variance 1.
    pub fn normal_at(&self, index: u64) -> f64 {
        let [[a, b, _]] = self.drawn_at([index]);
        normal_pair(a, b)[0]
    }

    /// The uniform number at `index`, in `[0, 1)`; independent of [`Self::normal_at`] at the same index.
    pub fn uniform_at(&self, index: u64) -> f64 {
        let [[.., uniform]] = self.drawn_at([index]);
        unit_interval(uniform)
    }

    /// Two independent standard normal numbers for each of `N` indices from `first` onwards; the first of
    /// each pair is [`Self::normal_at`].
    pub fn normal_pairs_from<const N: usize>(&self, first: u64) -> [[f64; 2]; N] {
        let mut pairs = [[0.0; 2]; N];
        for (start, pairs) in (first..).step_by(ABREAST).zip(pairs.chunks_mut(ABREAST)) {
            let drawn = self.drawn_at::<ABREAST>(std::array::from_fn(|i| start + i as u64));
            pairs.iter_mut().zip(drawn).for_each(|(pair, [a, b, _])| *pair = normal_pair(a, b));
        }
        pairs
    }

    /// The bits of a pair of normals and of a uniform number at each index. An index has half a block.
    fn drawn_at<const N: usize>(&self, indices: [u64; N]) -> [[u64; 3]; N] {
        let words = dispatch(
            #[inline(always)]
            || blocks(&self.key, indices.map(|index| index / 2)),
        );
        std::array::from_fn(|i| {
            let half = (indices[i] % 2) as usize * 8;
            [0, 2, 4].map(|at| u64::from(words[half + at][i]) | u64::from(words[half + at + 1][i]) << 32)
        })
    }
}

/// The normal numbers of a stream for one reader. Readers follow clocks, so the numbers of the next instants
/// are drawn together. They are those of [`Stream::normal_at`] whatever the instants.
#[derive(Clone, Debug)]
pub struct Draws {
    stream: Stream,
    /// Index and number of the next instants, if they keep their distance.
    ahead: [(u64, f64); ABREAST],
    /// Position of the next of these numbers.
    next: usize,
    /// Index of the last instant, and its distance from the one before.
    last: u64,
    distance: u64,
}

impl Draws {
    /// The numbers of a stream.
    pub fn new(stream: Stream) -> Self {
        Self { stream, ahead: [(0, 0.0); ABREAST], next: ABREAST, last: 0, distance: 0 }
    }

    /// The standard normal number at `index`.
    #[inline(always)]
    pub fn normal_at(&mut self, index: u64) -> f64 {
        let normal = match self.ahead.get(self.next) {
            Some((known, normal)) if *known == index => {
                self.next += 1;
                *normal
            }
            _ => self.draw(index),
        };
        self.last = index;
        normal
    }

    #[cold]
    fn draw(&mut self, index: u64) -> f64 {
        let distance = index.wrapping_sub(self.last);
        let is_even = distance == self.distance;
        self.distance = distance;
        if !is_even {
            self.next = ABREAST;
            return self.stream.normal_at(index);
        }
        let indices: [u64; ABREAST] =
            std::array::from_fn(|i| index.wrapping_add(distance.wrapping_mul(i as u64)));
        let drawn = self.stream.drawn_at(indices);
        self.ahead = std::array::from_fn(|i| (indices[i], normal_pair(drawn[i][0], drawn[i][1])[0]));
        self.next = 1;
        self.ahead[0].1
    }
}

/// A block of the generator at each counter, word by word.
#[inline(always)]
fn blocks<const N: usize>(key: &[u32; 8], counters: [u64; N]) -> [[u32; N]; 16] {
    let mut start = [[0; N]; 16];
    for (row, word) in start.iter_mut().zip(WORDS.iter().chain(key)) {
        *row = [*word; N];
    }
    start[12] = counters.map(|counter| counter as u32);
    start[13] = counters.map(|counter| (counter >> 32) as u32);
    let mut words = start;
    for _ in 0..4 {
        for i in 0..4 {
            quarter_round(&mut words, [i, 4 + i, 8 + i, 12 + i]);
        }
        for i in 0..4 {
            quarter_round(&mut words, [i, 4 + (i + 1) % 4, 8 + (i + 2) % 4, 12 + (i + 3) % 4]);
        }
    }
    for (row, start) in words.iter_mut().zip(&start) {
        for (word, start) in row.iter_mut().zip(start) {
            *word = word.wrapping_add(*start);
        }
    }
    words
}

#[inline(always)]
#[expect(clippy::needless_range_loop, reason = "one loop over three rows")]
fn quarter_round<const N: usize>(words: &mut [[u32; N]; 16], [a, b, c, d]: [usize; 4]) {
    for (to, other, turned, bits) in [(a, b, d, 16), (c, d, b, 12), (a, b, d, 8), (c, d, b, 7)] {
        for i in 0..N {
            words[to][i] = words[to][i].wrapping_add(words[other][i]);
            words[turned][i] = (words[turned][i] ^ words[to][i]).rotate_left(bits);
        }
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
