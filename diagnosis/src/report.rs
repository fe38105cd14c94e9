//! The answer, with the fields of `diagnosis.json`.

use std::fmt;

use feeler_plant::description::Machine;
use feeler_plant::effects::Kind;
use indexmap::IndexMap;
use serde::Serialize;

use crate::adequacy::Adequacy;

/// The kind of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The accepted effects explain the gap.
    Explained,
    /// Several causes explain the gap about as well.
    Ambiguous,
    /// The library does not explain the remaining error.
    UnknownCause,
    /// Calibration alone closes the gap.
    NoGap,
    /// The records do not decide: the motion is too small, causes at several places explain as much, or
    /// calibration alone closes the gap with a doubtful value.
    NotIdentifiable,
}

/// Prediction errors over the check experiments, each divided by its channel's scale (root mean square).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Gap {
    /// Error of the believed machine.
    pub before: f64,
    /// Error of the calibrated machine.
    pub refit: f64,
    /// Error with the accepted effects.
    pub after: f64,
    /// Error that noise alone leaves.
    pub floor: f64,
    /// Share of the closable gap that the effects close.
    pub closed: f64,
    /// 90 % interval of `closed`, by bootstrap over the check experiments.
    pub closed_ci90: [f64; 2],
}

/// A fitted number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The most probable value, SI.
    pub value: f64,
    /// 90 % interval of the value, SI.
    pub ci90: [f64; 2],
    /// The SI unit.
    pub unit: String,
}

/// A place at which part of the gap appears.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Where {
    /// Place on the machine.
    pub place: &'static str,
    /// Probability that this place causes the gap.
    pub probability: f64,
    /// Column with the largest error.
    pub channel: String,
    /// Band with the largest error.
    pub band_hz: [f64; 2],
    /// Phase of the motion with the largest error: `free`, `approach`, `impact`, `contact` or `release`.
    pub phase: &'static str,
    /// The evidence for the place.
    pub evidence: String,
}

/// A cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cause {
    /// Kind of the cause in the library.
    pub kind: Kind,
    /// Name of the element with the cause.
    pub on: String,
    /// Place on the machine.
    pub place: &'static str,
    /// Probability that this is the cause or part of it.
    pub probability: f64,
    /// Parameters by name.
    pub parameters: IndexMap<&'static str, Estimate>,
    /// Share of the gap that this cause closes, of what the accepted effects close together; zero for causes
    /// that are not accepted.
    pub credit: f64,
    /// Whether the cause is part of the repaired machine.
    pub accepted: bool,
}

/// How a guide with dry friction yields before it slides, as fitted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GuidePresliding {
    /// Name of the guide.
    pub on: String,
    /// Its stiffness at rest.
    pub stiffness: Estimate,
    /// Damping ratio of the sliding mass on that stiffness.
    pub damping_ratio: Estimate,
}

/// A set of causes that was tried, with the result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Attempt {
    /// Kinds and elements, joined by `+`.
    pub causes: String,
    /// Gain of evidence over calibration alone on the check experiments, nats. `None` if nothing in the
    /// records indicated the set.
    pub gain_check: Option<f64>,
    /// Gain of evidence over calibration alone on all experiments, nats; `None` as for `gain_check`.
    pub gain_all: Option<f64>,
    /// Gain on the check experiments in a balance of forces, nats. `None` if a balance involves none of the
    /// causes.
    pub gain_balance: Option<f64>,
    /// Why the set was accepted or not.
    pub why: AttemptOutcome,
}

/// Result of a tried set of causes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AttemptOutcome {
    /// The set is the answer.
    Accepted,
    /// The fitted value is within tolerance of the believed one.
    WithinTolerance,
    /// The fitted value is nearly zero, or outside the range of an effect of this kind.
    NoEffect,
    /// The gain on the check experiments is too small.
    TooLittle {
        gained_nats: f64,
        /// Required gain, nats.
        needed_nats: f64,
    },
    /// The set explains as much as the answer.
    AsMuch,
    /// The set explains less than the answer.
    Less {
        /// Difference, nats.
        nats: f64,
    },
    /// The set explains more than the answer, but too little for the additional causes.
    More {
        /// Difference, nats.
        nats: f64,
    },
    /// The fit was stopped after a few steps.
    LeftEarly,
    NotFitted,
    /// The time ran out before the set was tried.
    NotTried,
    /// The time ran out before the set was fitted to the end.
    Unfinished,
}

impl AttemptOutcome {
    /// The outcome of an attempt whose fit was stopped after a few steps and not compared with the answer.
    pub(crate) fn of_few_steps(self) -> Self {
        match self {
            Self::AsMuch | Self::Less { .. } | Self::More { .. } => Self::LeftEarly,
            other => other,
        }
    }
}

impl fmt::Display for AttemptOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Accepted => f.write_str("accepted"),
            Self::WithinTolerance => f.write_str("fitted value within the tolerance of the believed one"),
            Self::NoEffect => f.write_str("fitted to nearly zero, or out of range"),
            Self::TooLittle { gained_nats, needed_nats } if *gained_nats <= -0.5 => write!(
                f,
                "predicts the check experiments worse, by log odds of {:.0}; a gain of {needed_nats:.0} is \
                 needed",
                -gained_nats
            ),
            Self::TooLittle { gained_nats, needed_nats } => {
                write!(
                    f,
                    "gains log odds of {gained_nats:.0} on the check experiments; {needed_nats:.0} are needed"
                )
            }
            Self::AsMuch => f.write_str("explains as much as what was accepted"),
            Self::Less { nats } => {
                write!(f, "explains less than what was accepted, by log odds of {nats:.0}")
            }
            Self::More { nats } => {
                write!(f, "explains more (log odds of {nats:.0}), which is too little for what it adds")
            }
            Self::LeftEarly => f.write_str("dropped early: others fit better"),
            Self::NotTried => f.write_str("not tried: the time ran out"),
            Self::Unfinished => f.write_str("not fitted to the end: the time ran out"),
            Self::NotFitted => f.write_str(
                "not tried: nothing in the records suggests it, or the machine could not move with it",
            ),
        }
    }
}

impl Serialize for AttemptOutcome {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The gap in one cell: root mean square of the anchored prediction's error over the channel's scale.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GapCell {
    /// Name of the column.
    pub channel: String,
    /// Band of frequencies.
    pub band_hz: [f64; 2],
    /// Phase of the motion: `free`, `approach`, `impact`, `contact` or `release`.
    pub phase: &'static str,
    /// Command level among experiments of the same engagement: `low`, `middle` or `high`.
    pub amplitude: &'static str,
    /// Error of the believed machine.
    pub before: f64,
    /// Error of the calibrated machine.
    pub refit: f64,
    /// Error with the accepted effects.
    pub after: f64,
    /// Error that noise alone leaves.
    pub floor: f64,
    /// Time that the cell covers.
    pub seconds: f64,
}

/// One point of a portrait.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PortraitPoint {
    /// Position of the first drive's body relative to its reaction body.
    pub position_m: f64,
    /// Speed of this position, m/s.
    pub velocity_m_per_s: f64,
    /// Force of the drive.
    pub drive_n: f64,
    /// Time in the experiment.
    pub time_s: f64,
    /// The force that the calibrated machine lacks.
    pub missing_n: f64,
}

/// One rung of the disturbance ladder: the error that an unknown force at one place would explain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rung {
    /// Place on the machine.
    pub place: &'static str,
    /// Misfit of the calibrated machine that a force there would explain, nats.
    pub evidence: f64,
    /// Root mean square of that force, N.
    pub rms_n: f64,
    /// Share of the force's variance that depends on position, velocity, drive force and time.
    pub goes_with: [(&'static str, f64); 4],
    /// The force at single instants, with the motion at these instants.
    pub portrait: Vec<PortraitPoint>,
}

/// A force that no effect of the library explains, as a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForceOver {
    /// Kind of the table.
    pub kind: Kind,
    /// Name of the element with the table.
    pub on: String,
    /// The quantity on which the force depends: `position`, `speed` or `position and direction`.
    pub over: &'static str,
    /// Position or speed of each point, and the force there, SI. For `position and direction` the force is a
    /// friction level.
    pub knots: Vec<[f64; 2]>,
    /// Share of the gap that the table closes on the check experiments, beyond the answer without it.
    pub closed: f64,
}

/// Largest odds that are stated; larger ones are reduced to it.
pub const MOST_ODDS: f64 = 1e6;

/// The experiment that would best separate two causes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NextExperiment {
    /// The experiment in one sentence.
    pub what: String,
    /// The causes that it separates.
    pub separates: [Kind; 2],
    /// Expected odds of the true cause against the other one, as a ratio. A million stands for larger odds
    /// too.
    pub expected_odds: f64,
    /// Engagement of the contact: `free`, `clamped` or `unilateral`.
    pub engagement: &'static str,
    /// Largest travel of the first drive's body backward and forward from its start, with either cause, m.
    pub travel_m: [f64; 2],
    /// Largest speed of the first drive's body, m/s.
    pub top_speed_m_per_s: f64,
    /// Spacing of the command, s.
    pub spacing_s: f64,
    /// The command, ready to be written as an excitation file.
    #[serde(skip)]
    pub command: Vec<f64>,
}

/// The whole answer.
#[derive(Clone, Debug, Serialize)]
pub struct Diagnosis {
    /// Kind of the answer: `explained`, `ambiguous`, `unknown-cause`, `no-gap` or `not-identifiable`.
    pub verdict: Verdict,
    /// The gap, and the share of it that closes.
    pub gap: Gap,
    /// Remaining absolute errors at every horizon, and the reasons why the answer is not `explained`.
    pub adequacy: Adequacy,
    /// Places of the gap, the most probable first.
    #[serde(rename = "where")]
    pub places: Vec<Where>,
    /// Accepted and rival causes, the most probable first.
    pub effects: Vec<Cause>,
    /// Causes that these records can hardly separate from the accepted ones.
    pub look_alikes: Vec<[Kind; 2]>,
    /// How guides yield before they slide, where the records show it and the file does not state it. The
    /// repaired machine has it as its effect `presliding`. It is not a cause.
    pub presliding: Vec<GuidePresliding>,
    /// All attempts, the best first.
    pub attempts: Vec<Attempt>,
    /// The experiment that would best separate the remaining causes. `None` if one cause remains, or if no
    /// template separates them.
    pub next_experiment: Option<NextExperiment>,
    /// The gap by channel, band of frequencies, phase of the motion and amplitude.
    pub cells: Vec<GapCell>,
    /// Misfit that an unknown force at each place would explain, with a portrait of that force.
    pub ladder: Vec<Rung>,
    /// Root mean square of the missing force on the check experiments, after calibration and with the
    /// accepted effects, N.
    pub missing_force_n: [f64; 2],
    /// Shapes in the force that is missing with the accepted effects.
    pub left: Vec<String>,
    /// The missing force as a table, which is then part of the repaired machine. `None` unless no cause is
    /// found and the check experiments confirm the table.
    pub table: Option<ForceOver>,
    /// Standard deviation of every column's noise: as stated, or more if repeated experiments differ by more.
    /// If none is stated, it follows from the scatter of the readings and from differences between laps.
    pub noise: IndexMap<String, f64>,
    /// Warnings about the data.
    pub warnings: Vec<String>,
    /// Warnings of contradictions between records (units, clocks), and of signs that an accepted gain
    /// reverses. They may explain the findings.
    pub contradictions: Vec<String>,
    /// Force that the believed and the repaired machine lack along the first check experiment:
    /// `[t, x, v, F_believed, F_repaired]`.
    #[serde(skip)]
    pub inverse: Vec<[f64; 5]>,
    /// The believed machine with fitted values and accepted effects.
    #[serde(skip)]
    pub machine: Machine,
    /// The believed machine with fitted values only.
    #[serde(skip)]
    pub calibrated: Machine,
}
