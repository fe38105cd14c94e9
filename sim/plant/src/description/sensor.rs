//! Sensors and their imperfections.

use super::SignalName;
use crate::effects::EffectUse;

/// What a sensor reads and how it departs from the truth:
/// `reading = round_to(resolution, gain * low_pass(signal(t - delay)) + bias + noise)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// The signal it reads.
    pub reads: SignalName,
    /// The body it rides on, for motion sensors; absolute where absent.
    pub relative_to: Option<String>,
    /// Scale factor.
    pub gain: f64,
    /// Offset, in units of the signal.
    pub bias: f64,
    /// Analogue filter before sampling.
    pub low_pass: Option<LowPass>,
    /// Pure delay, >= 0.
    pub delay_s: f64,
    /// Quantisation step, > 0.
    pub resolution: Option<f64>,
    /// One sigma of white Gaussian noise per reading.
    pub noise: f64,
    /// Departures from the ideal sensor.
    pub effects: Vec<EffectUse>,
}

impl Sensor {
    /// A sensor that reads the signal as it is.
    pub fn ideal(reads: SignalName) -> Self {
        Self {
            reads,
            relative_to: None,
            gain: 1.0,
            bias: 0.0,
            low_pass: None,
            delay_s: 0.0,
            resolution: None,
            noise: 0.0,
            effects: Vec::new(),
        }
    }
}

/// A continuous low-pass filter of unit gain at zero frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LowPass {
    /// `1 / (1 + s / (2 pi f))`.
    FirstOrder {
        /// Corner frequency.
        corner_hz: f64,
    },
    /// `w^2 / (s^2 + 2 zeta w s + w^2)`, `w = 2 pi f`.
    SecondOrder {
        /// Natural frequency.
        corner_hz: f64,
        /// Damping ratio `zeta`.
        damping_ratio: f64,
    },
}
