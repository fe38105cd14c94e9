//! The answer to a case, and its score.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

/// The answer to a case: the parts of `diagnosis.json` that are scored, and the errors of the repaired
/// machine on experiments held back.
///
/// The verdict is that of the diagnosis, or says why there is none.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Answered {
    /// Name of the case.
    pub case: String,
    /// `explained`, `ambiguous`, `unknown-cause`, `no-gap` or `not-identifiable`.
    pub verdict: String,
    /// Places, the most probable first.
    pub places: Vec<String>,
    /// Causes, accepted and rival, the most probable first.
    pub effects: Vec<AnsweredEffect>,
    /// Kinds declared to look alike.
    pub look_alikes: Vec<[String; 2]>,
    /// Share of the gap that the answer claims to close.
    pub claimed: f64,
    /// Share that closes on the experiments held back, if there are any.
    pub closed_held_back: Option<f64>,
    /// Errors of free runs over the scale of each column, by the believed and by the repaired machine.
    #[serde(default)]
    pub free_run: Option<[f64; 2]>,
    /// Wall time of the diagnosis, s.
    pub wall_s: f64,
}

/// A cause that was answered.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct AnsweredEffect {
    /// Kind of the cause.
    pub kind: String,
    /// Whether the cause is part of the repaired machine.
    pub accepted: bool,
    /// Stated probability.
    pub probability: f64,
    /// Values by name, SI.
    pub parameters: IndexMap<String, f64>,
    /// Stated 90 % intervals of the values.
    #[serde(default)]
    pub intervals: IndexMap<String, [f64; 2]>,
}

/// One line of the table of measures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measure {
    /// Name of the measure.
    pub what: &'static str,
    /// The measured number; `None` if no case counts.
    pub value: Option<f64>,
    /// Unit of the number.
    #[serde(skip)]
    pub unit: MeasureUnit,
    /// Number of cases that count.
    pub cases: usize,
    /// The goal, in words.
    pub wanted: String,
    /// Whether the value meets the goal.
    pub reached: bool,
}

/// Unit of the number of a measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasureUnit {
    /// A share, to be shown in percent.
    Share,
    /// A time, s.
    Seconds,
}

/// One bin of the reliability diagram.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// Smallest and largest stated probability of this group.
    pub stated: [f64; 2],
    /// Mean of the stated probabilities.
    pub mean_stated: f64,
    /// Share of these answers that were right.
    pub frequency: f64,
    /// Number of answers in the group.
    pub count: usize,
}

/// One case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaseScore {
    /// Name of the case.
    pub case: String,
    /// Kinds that were hidden.
    pub hidden: Vec<String>,
    /// Kinds that were accepted.
    pub answered: Vec<String>,
    /// The verdict of the diagnosis.
    pub verdict: String,
    /// Whether the answer counts as right by the measure for its hidden effects.
    pub right: bool,
    /// Whether the answer says `explained` and misses a hidden effect, or names an effect that is not hidden.
    pub sure_and_wrong: bool,
    /// The kind that the plain regression names, if any.
    pub regression: Option<String>,
    /// The values of hidden effects that were found.
    pub values: Vec<ScoredValue>,
}

/// A hidden value and its estimate, SI.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScoredValue {
    /// Kind of the effect.
    pub kind: String,
    /// Name of the parameter.
    pub parameter: String,
    /// The hidden value.
    pub hidden: f64,
    /// The fitted value; `None` if the answer has none.
    pub fitted: Option<f64>,
    /// Stated 90 % interval of the fitted value; `None` if the answer has none.
    pub interval: Option<[f64; 2]>,
}

/// All scores.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Score {
    /// The table of measures.
    pub measures: Vec<Measure>,
    /// Hidden kind, answered kind and number of cases. Cases with several hidden effects are left out.
    pub confusion: Vec<(String, String, usize)>,
    /// Claimed probabilities against the shares of answers that were right.
    pub reliability: Vec<Calibration>,
    /// Every case that has an answer.
    pub cases: Vec<CaseScore>,
    /// Number of cases without an answer.
    pub unanswered: usize,
}

/// Name of a case without a hidden effect.
pub const NOTHING: &str = "nothing";
/// Name of an answer with an unknown cause.
pub const UNKNOWN: &str = "unknown cause";
