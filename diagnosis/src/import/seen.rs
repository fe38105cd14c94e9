//! Findings on a joint and its servo from a log.

use super::guess::Guess;
use super::role::ColumnRole;
use super::roles::Amount;

/// A load counts as the cause of an error if it explains at least this share of the squared error.
const LEAST_EXPLAINED: f64 = 0.25;

/// Findings on a joint.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    /// How much later the position follows, s.
    pub(super) lag_s: Option<f64>,
    /// Errors under loads.
    pub(super) held: Held,
    /// Step of the encoder.
    pub(super) step: Option<f64>,
    /// Whether the units of its columns are those of a slide.
    pub(super) is_straight: bool,
    /// Whether targets come with their speed.
    pub(super) has_speed: bool,
    /// Whether targets come with a force that the servo adds.
    pub(super) has_lead: bool,
    /// The unit of the command of a force drive.
    pub(super) command: Amount,
}

impl Seen {
    /// Findings on the choice of columns.
    pub(super) fn of(guess: &Guess) -> Self {
        let command = guess.columns.get(&ColumnRole::Command);
        Self {
            lag_s: guess.follow.map(|follow| follow.lag_s),
            is_straight: guess.is_straight(),
            has_speed: guess.columns.contains_key(&ColumnRole::TargetVelocity),
            has_lead: guess.columns.contains_key(&ColumnRole::FeedForward),
            command: command.map(|chosen| Amount::of(&chosen.column)).unwrap_or_default(),
            ..Self::default()
        }
    }
}

/// Sums over rows of an error under a known load.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Held {
    rows: f64,
    load_load: f64,
    load_error: f64,
    error_error: f64,
}

impl Held {
    pub(super) fn add(&mut self, load: f64, error: f64) {
        if load.is_finite() && error.is_finite() {
            self.rows += 1.0;
            self.load_load += load * load;
            self.load_error += load * error;
            self.error_error += error * error;
        }
    }

    /// Load over error, by least squares: friction and motion disturb the error, not the load. `None` if the
    /// rms load is at most `least`, or explains too little.
    pub(super) fn gain(&self, least: f64) -> Option<f64> {
        let gain = -self.load_load / self.load_error;
        let is_loaded = self.load_load > self.rows * least.powi(2) && self.load_load > 0.0;
        let explained = self.load_error.powi(2) / (self.load_load * self.error_error);
        (is_loaded && explained > LEAST_EXPLAINED && gain.is_finite() && gain > 0.0).then_some(gain)
    }
}
