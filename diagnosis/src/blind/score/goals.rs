//! The goals of a score.

use super::super::cases::Case;

/// Goals as shares, and wall times in seconds.
pub(super) struct Goals {
    pub(super) sure_and_wrong: f64,
    pub(super) place: f64,
    pub(super) kind: f64,
    pub(super) pair: f64,
    pub(super) outside: f64,
    pub(super) alarm: f64,
    pub(super) calibration: f64,
    pub(super) median_s: f64,
    pub(super) worst_s: f64,
}

impl Goals {
    /// Goals for the bench with several channels and levels.
    pub(super) const ORDINARY: Self = Self {
        sure_and_wrong: 0.01,
        place: 0.97,
        kind: 0.97,
        pair: 0.9,
        outside: 0.9,
        alarm: 0.0,
        calibration: 0.05,
        median_s: 6.0,
        worst_s: 60.0,
    };
    /// Goals for cases with the conditions of real records.
    pub(super) const WILD: Self = Self {
        sure_and_wrong: 0.02,
        place: 0.9,
        kind: 0.85,
        pair: 0.7,
        outside: 0.8,
        alarm: 0.02,
        calibration: 0.05,
        median_s: 20.0,
        worst_s: 120.0,
    };
    /// Goals for servo joints with target and position only: those of wild cases.
    pub(super) const SERVO: Self = Self { ..Self::WILD };

    /// Goals for the bench that made these cases.
    pub(super) fn of(truth: &[Case]) -> &'static Self {
        if truth.iter().any(|case| case.servo.is_some()) {
            &Self::SERVO
        } else if truth.iter().any(|case| case.conditions.is_some()) {
            &Self::WILD
        } else {
            &Self::ORDINARY
        }
    }
}
