//! Random numbers of the benchmark.

/// A small generator (`SplitMix` of Steele, Lea and Flood), repeatable on every machine.
#[derive(Clone, Debug)]
pub(super) struct Random {
    state: u64,
}

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self { state: seed.wrapping_mul(0xD129_0C3A_55B1_4E27).wrapping_add(0x632B_E59B_D9B4_E019) }
    }

    pub(super) fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Between 0 and 1.
    pub(super) fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Uniform in the logarithm.
    pub(super) fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    pub(super) fn sign(&mut self) -> f64 {
        if self.share() < 0.5 { -1.0 } else { 1.0 }
    }

    pub(super) fn pick(&mut self, n: usize) -> usize {
        ((self.share() * n as f64) as usize).min(n.saturating_sub(1))
    }

    /// Normal, of unit variance (Box and Muller).
    pub(super) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.share()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.share()).cos()
    }
}

/// Noise with memory: first-order, of unit variance.
#[derive(Clone, Debug)]
pub(super) struct Coloured {
    memory: f64,
    now: f64,
}

impl Coloured {
    pub(super) fn new(memory_s: f64, spacing_s: f64) -> Self {
        Self { memory: (-spacing_s / memory_s).exp(), now: 0.0 }
    }

    pub(super) fn next(&mut self, random: &mut Random) -> f64 {
        self.now = self.memory * self.now + (1.0 - self.memory * self.memory).sqrt() * random.normal();
        self.now
    }
}
