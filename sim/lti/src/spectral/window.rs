//! Windows.

use std::f64::consts::TAU;

/// A data window, in its periodic form (that of n + 1 points without the last), which is the one for spectra.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Window {
    /// No window.
    Rectangular,
    /// Raised cosine: the usual choice.
    #[default]
    Hann,
    /// Hamming's window: lower first side lobe, slower decay.
    Hamming,
    /// Blackman's window: side lobes below -58 dB.
    Blackman,
    /// Flat top (HFT70 of Heinzel, Ruediger and Schilling 2002): amplitudes of lines to 0.1 %.
    FlatTop,
}

impl Window {
    /// The n weights.
    pub fn weights(self, n: usize) -> Vec<f64> {
        let cosines: &[f64] = match self {
            Self::Rectangular => &[1.0],
            Self::Hann => &[0.5, -0.5],
            Self::Hamming => &[0.54, -0.46],
            Self::Blackman => &[0.42, -0.5, 0.08],
            Self::FlatTop => &[1.0, -1.90796, 1.07349, -0.18199],
        };
        let weight = |i: usize| cosines.iter().enumerate().map(|(k, a)| a * (TAU * (k * i) as f64 / n as f64).cos()).sum();
        (0..n).map(weight).collect()
    }
}
