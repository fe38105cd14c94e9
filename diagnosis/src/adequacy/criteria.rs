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
    /// A smooth force that no cause makes counts where it gains more than this on the check experiments, nats,
    /// takes more than this share out of the variance that is left, and is more than this share of the
    /// drive's force.
    pub smooth_nats: f64,
    /// See [`Self::smooth_nats`].
    pub smooth_share: f64,
    /// The same of a force in the drive: at reversals, where the command is largest, friction that turns a
    /// little otherwise passes for one.
    pub smooth_drive_share: f64,
    /// See [`Self::smooth_nats`].
    pub smooth_force: f64,
    /// Force still missing in a balance over the drive's below which an answer stands whatever short predictions
    /// leave in sigmas.
    pub small_force: f64,
    /// A fitted mass over the believed mass beside it (or the inverse), a gain or its inverse, above which
    /// the value is no property of the believed machine.
    pub most_ratio: f64,
    /// A fitted force over the largest command above which no motion would be left.
    pub most_force: f64,
    /// A fitted force over the largest command, and a fitted time over the spacing of rows, below which
    /// an effect cannot be distinguished from none.
    pub least_force: f64,
    /// See [`Self::least_force`].
    pub least_rows: f64,
    /// A rival of another place whose evidence on the check experiments lies within this, nats, predicts
    /// them as well.
    pub rival_nats: f64,
    /// A further cause that brings more than this on the check experiments, nats, and twice as much on all, may
    /// be there although it is not accepted: where a balance weighs.
    pub further_nats: f64,
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
            small_force: 0.1,
            smooth_nats: 20.0,
            smooth_share: 0.33,
            smooth_drive_share: 0.6,
            smooth_force: 0.02,
            most_ratio: 3.0,
            most_force: 1.0,
            least_force: 1e-3,
            least_rows: 0.05,
            rival_nats: 2.0,
            further_nats: 6.0,
            rival_share: 0.8,
        }
    }
}
