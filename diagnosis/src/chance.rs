//! Random numbers that are equal in every run.

/// A linear congruential generator: enough for a bootstrap and for trials with noise.
pub(crate) struct Chance(u64);

impl Default for Chance {
    fn default() -> Self {
        Self(0x9E37_79B9_7F4A_7C15)
    }
}

impl Chance {
    pub(crate) fn seeded(seed: u64) -> Self {
        Self(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0
    }

    /// A random number from 0 to `n - 1`.
    pub(crate) fn pick(&mut self, n: usize) -> usize {
        (self.bits() >> 33) as usize % n
    }

    /// A uniform random number of zero mean and unit variance.
    pub(crate) fn deviate(&mut self) -> f64 {
        ((self.bits() >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
    }

    /// A nearly normal random number of zero mean and unit variance: a sum of four uniform ones.
    pub(crate) fn normal(&mut self) -> f64 {
        0.5 * (0..4).map(|_| self.deviate()).sum::<f64>()
    }
}
