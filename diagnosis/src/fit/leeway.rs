//! Freedoms of a model beyond the values of its machine: how guides give way, and when commands act.

use crate::fit::model::{DIFFERENCE, Model};
use crate::fit::unknown::{SIGMAS, Target, Unknown};
use crate::predict::{Leeway, Presliding};

/// Step of finite differences for the timing of commands, rows.
const TIMING_DIFFERENCE: f64 = 1e-2;
/// Commands act at most this much before or after their rows, where no hold is stated.
const MOST_LATE_ROWS: f64 = 0.5;

/// Shift of the trial frequency of sticking guides, as a logarithm.
const STIFFER: f64 = 1.4;

/// Prior standard deviations of pre-sliding frequency and damping ratio, as logarithms.
const PRESLIDING_SPREAD: [f64; 2] = [1.2, 1.0];

impl Model {
    /// The same, where the instants at which commands act are not stated: up to half a row earlier or later
    /// than the row. Half a row later is a command that was held.
    pub(crate) fn with_free_timing(mut self) -> Self {
        self.unknowns.push(Unknown {
            target: Target::CommandTiming,
            log: false,
            unit: 1.0,
            prior: Some((0.0, MOST_LATE_ROWS / SIGMAS)),
            bounds: (-MOST_LATE_ROWS, MOST_LATE_ROWS),
            difference: TIMING_DIFFERENCE,
        });
        self
    }

    /// Adds the pre-sliding of sticking guides to the unknowns.
    pub(super) fn free_presliding(&mut self) {
        let usual = Presliding::default();
        for (target, value, sigma) in [
            (Target::PreslidingFrequency, usual.frequency_hz, PRESLIDING_SPREAD[0]),
            (Target::PreslidingDamping, usual.damping_ratio, PRESLIDING_SPREAD[1]),
        ] {
            let centre = value.ln();
            let bounds = (centre - 2.0 * sigma, centre + 2.0 * sigma);
            let prior = Some((centre, sigma));
            self.unknowns.push(Unknown {
                target,
                log: true,
                unit: 1.0,
                prior,
                bounds,
                difference: DIFFERENCE,
            });
        }
    }

    /// The start itself, and the same with sticking guides at lower and higher frequencies. Only the start if
    /// none sticks.
    pub(crate) fn stiffer(&self, start: &[f64]) -> Vec<Vec<f64>> {
        let Some(i) = self.unknowns.iter().position(|unknown| unknown.target == Target::PreslidingFrequency)
        else {
            return vec![start.to_vec()];
        };
        let at = |shift: f64| {
            let mut start = start.to_vec();
            start[i] = (start[i] + shift).clamp(self.unknowns[i].bounds.0, self.unknowns[i].bounds.1);
            start
        };
        [-STIFFER, 0.0, STIFFER].map(at).to_vec()
    }

    /// Whether commands act as early or late as they may.
    pub(crate) fn is_timing_at_limit(&self, theta: &[f64]) -> bool {
        let is_it = |(unknown, theta): (&Unknown, &f64)| {
            unknown.target == Target::CommandTiming && unknown.is_at_limit(*theta)
        };
        self.unknowns.iter().zip(theta).any(is_it)
    }

    /// The free quantities beyond the machine's values, at `theta`.
    pub(crate) fn leeway(&self, theta: &[f64]) -> Leeway {
        let mut found = Leeway::default();
        for (unknown, &theta) in self.unknowns.iter().zip(theta) {
            match unknown.target {
                Target::PreslidingFrequency => found.presliding.frequency_hz = unknown.value(theta),
                Target::PreslidingDamping => found.presliding.damping_ratio = unknown.value(theta),
                Target::CommandTiming => found.late_rows = unknown.value(theta),
                _ => {}
            }
        }
        found
    }
}
