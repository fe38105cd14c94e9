//! The swept sine.

use std::f64::consts::TAU;

use super::keys::{AMPLITUDE, DURATION, END, START, key};
use super::spec::ChirpSweep;
use crate::error::{ControlError, finite, not_negative, positive};

/// `A sin(phase(t))` with phase zero at the start. For the frequency `f0 + (f1 - f0) t / D` the phase is `2
/// pi (f0 t + (f1 - f0) t^2 / (2 D))`. For `f0 (f1 / f0)^(t / D)` the phase is `2 pi f0 D / ln(f1 / f0) ((f1
/// / f0)^(t / D) - 1)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chirp {
    sweep: ChirpSweep,
    amplitude: f64,
    start_hz: f64,
    end_hz: f64,
    duration_s: f64,
}

impl Chirp {
    pub(super) fn new(
        sweep: ChirpSweep,
        amplitude: f64,
        start_hz: f64,
        end_hz: f64,
        duration_s: f64,
    ) -> Result<Self, ControlError> {
        let edge = match sweep {
            ChirpSweep::Linear => not_negative,
            ChirpSweep::Logarithmic => positive,
        };
        Ok(Self {
            sweep,
            amplitude: finite(key(&AMPLITUDE), amplitude)?,
            start_hz: edge(key(&START), start_hz)?,
            end_hz: edge(key(&END), end_hz)?,
            duration_s: positive(key(&DURATION), duration_s)?,
        })
    }

    pub(super) fn value(&self, t_s: f64) -> f64 {
        if !(0.0..=self.duration_s).contains(&t_s) {
            return 0.0;
        }
        let share = t_s / self.duration_s;
        let cycles_per_s = match self.sweep {
            ChirpSweep::Linear => self.start_hz + 0.5 * (self.end_hz - self.start_hz) * share,
            ChirpSweep::Logarithmic => {
                let x = (self.end_hz / self.start_hz).ln() * share;
                // The mean frequency so far; its limit if both ends are equal.
                self.start_hz * if x == 0.0 { 1.0 } else { x.exp_m1() / x }
            }
        };
        self.amplitude * (TAU * cycles_per_s * t_s).sin()
    }
}
