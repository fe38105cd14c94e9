//! The limits that an answer must meet to be called explained.

use serde::Serialize;

/// Limits that an explained answer must meet. The values are written to `diagnosis.json`.
///
/// They limit what matters to an engineer. They are not levels of significance: over minutes of records every
/// difference is significant. At each limit the hidden effects of the practice cases pass, and the residual
/// of effects outside the library does not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Criteria {
    /// Largest error of short predictions, in noise floors.
    pub most_floors: f64,
    /// Largest error as a share of every channel's variation; it applies where the floor is tiny and a cause
    /// was found. Without a cause `slight` applies there.
    pub most_left: f64,
    /// Largest error of predictions over up to a second, as a share of every channel's variation, beyond
    /// [`Self::most_floors`]. It applies to machines without contacts only, because an impact soon changes
    /// the whole motion.
    pub most_left_far: f64,
    /// Error of the calibrated machine's short predictions, as a share of every channel's variation. A
    /// smaller error is too small to name a cause, unless the causes explain all of it, or remove
    /// [`Self::least_closed`] of one above two noise floors.
    pub slight: f64,
    /// The limit `slight` for longer horizons of up to a second.
    pub slight_far: f64,
    /// Least share of the error beyond the floor that the causes must remove. It counts in short predictions
    /// of the calibrated machine: a cause that removes less explains little of the gap.
    pub least_closed: f64,
    /// Share that the causes must be able to remove, within its 90 % interval. If they surely remove less,
    /// there may be a further cause. On four seeds two of the three answers concerned were wrong.
    pub well_closed: f64,
    /// Limit on the missing force over the drive force (root mean squares over the check experiments). Above
    /// it the missing force must have fallen to [`Self::most_of_missing_force`] of its value after
    /// calibration.
    pub most_missing_force: f64,
    /// Share of the missing force after calibration that may remain where `most_missing_force` is exceeded.
    pub most_of_missing_force: f64,
    /// At every horizon the repaired machine's error must stay below this multiple of the calibrated one's,
    /// or at the noise. Two fits of the same values differ by up to one in a hundred.
    pub most_worsening: f64,
    /// A prediction whose error exceeds this multiple of the channel's variation has lost the motion. The
    /// calibrated and the repaired machine are not compared there, unless the repaired one is far worse.
    pub lost: f64,
    /// Limit on a force that correlates with command, position, direction, speed or a frequency, beyond what
    /// chance gives. It is relative to the drive force (root mean squares). Above it a residual has
    /// structure.
    pub most_structure: f64,
    /// Lower limit for structure that also makes up [`Self::most_of_missing_force`] of the force missing
    /// after calibration.
    pub some_structure: f64,
    /// Number of time shifts of the residual by which its chance correlation is measured. The largest
    /// correlation counts.
    pub chance_shifts: usize,
    /// A smooth force beyond the causes counts if it gains more than this on the check experiments, nats. It
    /// must also remove more than `smooth_share` of the remaining variance, and exceed `smooth_force` of the
    /// drive force.
    pub smooth_nats: f64,
    /// Share of the remaining variance that a smooth force must remove to count.
    pub smooth_share: f64,
    /// Ratio to the drive force that a smooth force must exceed to count.
    pub smooth_force: f64,
    /// Ratio of the missing force to the drive force in the balance, below which an answer is accepted. The
    /// error of short predictions in sigmas then does not count.
    pub small_force: f64,
    /// Largest ratio of a fitted mass to the believed mass beside it, or of a gain to one (or the inverse).
    /// Beyond it the value is not a property of the believed machine.
    pub most_ratio: f64,
    /// Largest ratio of a fitted force to the largest command. A larger force would stop all motion.
    pub most_force: f64,
    /// Smallest ratio of a fitted force to the largest command. A smaller force cannot be distinguished from
    /// zero.
    pub least_force: f64,
    /// Smallest ratio of a fitted time to the spacing of the rows. A shorter time cannot be distinguished
    /// from zero.
    pub least_rows: f64,
    /// A rival at another place predicts as well if its evidence on the check experiments is at most this
    /// much lower, nats. So does a smooth force balance as well instead of causes elsewhere.
    pub rival_nats: f64,
    /// A further cause may be present if it gains more than this on the check experiments, nats, and twice as
    /// much on all experiments. This applies where a balance of forces counts. A smooth force that gains more
    /// than this over causes elsewhere balances better.
    pub further_nats: f64,
    /// A rival predicts better if its error at a longer horizon is below this share of the accepted
    /// machine's.
    pub rival_share: f64,
}

impl Default for Criteria {
    fn default() -> Self {
        Self {
            most_floors: 4.0,
            most_left: 0.05,
            most_left_far: 0.25,
            slight: 0.005,
            slight_far: 0.02,
            least_closed: 0.5,
            well_closed: 0.75,
            most_missing_force: 0.2,
            most_of_missing_force: 0.5,
            most_worsening: 1.01,
            lost: 1.0,
            most_structure: 0.1,
            some_structure: 0.05,
            chance_shifts: 19,
            small_force: 0.1,
            smooth_nats: 20.0,
            smooth_share: 0.33,
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
