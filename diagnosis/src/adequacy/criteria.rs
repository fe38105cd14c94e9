//! When "explained" may be said.

use serde::Serialize;

/// What an answer must hold to be called explained. The values stand in `diagnosis.json`.
///
/// They are limits of what matters to an engineer, not levels of significance: over minutes of records every
/// difference is significant. Each was set so that the hidden effects of the practice cases pass and what is
/// left of effects outside the library does not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Criteria {
    /// What is left may be this many noise floors, in short predictions.
    pub most_floors: f64,
    /// Or this share of every channel's variation, where the floor is tiny.
    pub most_left: f64,
    /// Force still missing over the drive's force (root mean squares over the check experiments) above which
    /// it must at least have fallen to [`Self::most_of_missing_force`] of that after calibration.
    pub most_missing_force: f64,
    /// See [`Self::most_missing_force`].
    pub most_of_missing_force: f64,
    /// At no horizon may the repaired machine's error be this many times that of the calibrated one.
    pub most_worsening: f64,
    /// Predictions that are off by this many times the channel's variation have lost the motion: there the
    /// calibrated and the repaired machine are not compared, unless the repaired one is far worse.
    pub lost: f64,
    /// Force that goes with command, position, direction, speed or a frequency, over the drive's force (root
    /// mean squares), above which a residual has structure. Beyond what chance gives it besides.
    pub most_structure: f64,
    /// Lower limit for structure that also makes up [`Self::most_of_missing_force`] of the force missing
    /// after calibration.
    pub some_structure: f64,
    /// Shifts of the residual against what it is compared with that say what chance gives; the largest
    /// counts.
    pub chance_shifts: usize,
    /// A fitted mass over the believed mass beside it (or the inverse), a gain or its inverse, above which
    /// the value is no property of the believed machine.
    pub most_ratio: f64,
    /// A fitted force over the largest command above which no motion would be left.
    pub most_force: f64,
    /// A rival of another place whose evidence on the check experiments lies within this, nats, predicts
    /// them as well.
    pub rival_nats: f64,
    /// A rival whose error at a longer horizon is below this share of the accepted machine's predicts better.
    pub rival_share: f64,
}

impl Default for Criteria {
    fn default() -> Self {
        Self {
            most_floors: 4.0,
            most_left: 0.05,
            most_missing_force: 0.2,
            most_of_missing_force: 0.5,
            most_worsening: 1.1,
            lost: 1.0,
            most_structure: 0.1,
            some_structure: 0.05,
            chance_shifts: 19,
            most_ratio: 5.0,
            most_force: 1.0,
            rival_nats: 2.0,
            rival_share: 0.8,
        }
    }
}
