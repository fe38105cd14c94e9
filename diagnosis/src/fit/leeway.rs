//! What a model frees beyond the values of its machine: how guides give way, and when commands act.

use std::f64::consts::TAU;

use feeler_plant::description::Quantity;

use crate::dataset::Dataset;
use crate::fit::model::{DIFFERENCE, Model};
use crate::fit::unknown::{SIGMAS, Target, Unknown};
use crate::fit::wander::commanded_acceleration;
use crate::predict::{Leeway, Presliding};

/// Step of finite differences for the timing of commands, rows.
const TIMING_DIFFERENCE: f64 = 1e-2;
/// Commands act at most this much before or after their rows, where no hold is stated.
const MOST_LATE_ROWS: f64 = 0.5;

/// Shift of the trial frequency of sticking guides, as a logarithm.
const STIFFER: f64 = 1.4;

/// Shares of the stroke, and of the step of its encoder, by which a sticking guide may yield unseen.
const UNSEEN_OF_STROKE: f64 = 3e-4;
const UNSEEN_OF_STEP: f64 = 0.3;
/// Largest expected frequency of a sticking guide, Hz.
const MOST_STICKING_HZ: f64 = 2000.0;

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

    /// The same, where sticking guides are expected to yield as these records could show: a heavy load on a
    /// light axis would bend the usual guide visibly.
    pub(crate) fn sticking_as_in(mut self, dataset: &Dataset) -> Self {
        self.presliding.frequency_hz = sticking_hz(dataset).max(self.presliding.frequency_hz);
        let count = self.unknowns.len();
        self.unknowns.retain(|unknown| !unknown.is_presliding());
        if self.unknowns.len() < count {
            self.free_presliding();
        }
        self
    }

    /// Adds the pre-sliding of sticking guides to the unknowns.
    pub(super) fn free_presliding(&mut self) {
        let Presliding { frequency_hz, damping_ratio } = self.presliding;
        for (target, value, sigma) in [
            (Target::PreslidingFrequency, frequency_hz, PRESLIDING_SPREAD[0]),
            (Target::PreslidingDamping, damping_ratio, PRESLIDING_SPREAD[1]),
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

    /// What is free beyond the machine's values, at `theta`.
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

/// Natural frequency at which sticking guides yield to the commands of a dataset by as much as nobody sees, Hz.
/// Zero if its commands are no forces.
fn sticking_hz(dataset: &Dataset) -> f64 {
    let is_position = |c: &usize| dataset.channels[*c].quantity(&dataset.machine) == Quantity::Position;
    let Some(c) = (0..dataset.channels.len()).find(is_position) else { return 0.0 };
    let of = |r: usize| {
        let series = &dataset.records[r].series[c];
        let [low, high] =
            series.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)]);
        let unseen = (UNSEEN_OF_STROKE * (high - low)).max(UNSEEN_OF_STEP * dataset.channels[c].resolution);
        if unseen > 0.0 { (commanded_acceleration(dataset, r) / unseen).sqrt() / TAU } else { 0.0 }
    };
    (0..dataset.records.len()).map(of).fold(0.0, f64::max).min(MOST_STICKING_HZ)
}
