//! Windows.

use std::f64::consts::TAU;

/// A data window in its periodic form (n + 1 points without the last), as required for spectra.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Window {
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
        let cosine = |k: usize, i: usize| if k == 0 { 1.0 } else { (TAU * (k * i) as f64 / n as f64).cos() };
        let weight = |i: usize| cosines.iter().enumerate().map(|(k, a)| a * cosine(k, i)).sum();
        // The second half mirrors the first one.
        let half: Vec<f64> = (0..=n / 2).map(weight).collect();
        (0..n).map(|i| half[i.min(n - i)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_weights_are_their_sums_of_cosines() {
        for n in 0..12 {
            let hann = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / n as f64).cos();
            let weights = Window::Hann.weights(n);
            assert_eq!(weights.len(), n);
            assert!(weights.iter().enumerate().all(|(i, w)| (w - hann(i)).abs() < 1e-15), "{n}: {weights:?}");
            assert!(Window::Rectangular.weights(n).iter().all(|w| w.to_bits() == 1.0_f64.to_bits()));
        }
    }
}
