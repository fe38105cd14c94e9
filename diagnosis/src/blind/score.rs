//! Scores: what was answered against what was hidden.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::cases::Case;

/// What was answered in a case: the parts of `diagnosis.json` that are scored, and what the repaired machine
/// does on experiments held back.
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
    /// Share of the gap said to close.
    pub claimed: f64,
    /// Share that closes on the experiments held back, where there are any.
    pub closed_held_back: Option<f64>,
    /// Error of free runs over the scale of each column, by the machine as believed and as repaired.
    #[serde(default)]
    pub free_run: Option<[f64; 2]>,
    /// Wall time of the diagnosis, s.
    pub wall_s: f64,
}

/// A cause that was answered.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct AnsweredEffect {
    /// Its kind.
    pub kind: String,
    /// Whether it is part of the repaired machine.
    pub accepted: bool,
    /// Stated probability.
    pub probability: f64,
    /// Values by name, SI.
    pub parameters: IndexMap<String, f64>,
    /// Their stated 90 % intervals.
    #[serde(default)]
    pub intervals: IndexMap<String, [f64; 2]>,
}

/// One line of the table of measures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measure {
    /// What is measured.
    pub what: &'static str,
    /// The number; none where no case counts.
    pub value: Option<f64>,
    /// How many cases count.
    pub cases: usize,
    /// What is to be reached, in words.
    pub wanted: &'static str,
    /// Whether it is reached.
    pub reached: bool,
}

/// One line of the reliability diagram.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// Stated probabilities between these.
    pub stated: [f64; 2],
    /// Their mean.
    pub mean_stated: f64,
    /// How often they were right.
    pub frequency: f64,
    /// How many there were.
    pub count: usize,
}

/// One case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaseScore {
    /// Its name.
    pub case: String,
    /// What was hidden.
    pub hidden: Vec<String>,
    /// What was accepted.
    pub answered: Vec<String>,
    /// The verdict.
    pub verdict: String,
    /// Whether the answer counts as right by the measure of its kind.
    pub right: bool,
}

/// All scores.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Score {
    /// The table of measures.
    pub measures: Vec<Measure>,
    /// Hidden kind, answered kind, how often; single effects, no effect and effects of no library.
    pub confusion: Vec<(String, String, usize)>,
    /// The reliability diagram.
    pub reliability: Vec<Calibration>,
    /// Every case that has an answer.
    pub cases: Vec<CaseScore>,
    /// How many have none.
    pub unanswered: usize,
}

/// Bins of stated probability.
const BINS: usize = 5;
/// Kinds that an answer may name as one.
const MOST_ALIKE: usize = 3;
/// Angles are compared on the circle, and bad ones say nothing of size.
const UNSCORED: &str = "phase";
/// What a case without effect is called.
pub const NOTHING: &str = "nothing";
/// What a refusal is called.
pub const UNKNOWN: &str = "unknown cause";
/// Verdicts that claim no effect.
const QUIET: [&str; 2] = ["no-gap", "not-identifiable"];

/// Counts of right answers.
#[derive(Default)]
struct Tally {
    right: usize,
    of: usize,
}

impl Tally {
    fn add(&mut self, right: bool) {
        self.of += 1;
        self.right += usize::from(right);
    }

    fn measure(&self, what: &'static str, wanted: &'static str, reached: impl Fn(f64) -> bool) -> Measure {
        let value = (self.of > 0).then(|| self.right as f64 / self.of as f64);
        Measure { what, value, cases: self.of, wanted, reached: value.is_some_and(reached) }
    }
}

/// Scores answers; hidden cases that have none are left out.
pub fn score(truth: &[Case], answers: &[Answered]) -> Score {
    let [mut place, mut first, mut top3, mut pair, mut outside, mut alarm, mut inside] =
        <[Tally; 7]>::default();
    let (mut errors, mut closed, mut claims, mut times) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut confusion: IndexMap<(String, String), usize> = IndexMap::new();
    let mut stated: Vec<(f64, bool)> = Vec::new();
    let mut cases = Vec::new();
    for (case, answer) in
        truth.iter().filter_map(|case| Some((case, answers.iter().find(|answer| answer.case == case.case)?)))
    {
        times.push(answer.wall_s);
        let accepted: Vec<&AnsweredEffect> = answer.effects.iter().filter(|effect| effect.accepted).collect();
        let said = match accepted.first() {
            _ if answer.verdict == "unknown-cause" => UNKNOWN,
            Some(effect) => effect.kind.as_str(),
            None => NOTHING,
        };
        let right = match case.effects.as_slice() {
            [] => {
                let quiet = accepted.is_empty() && QUIET.contains(&answer.verdict.as_str());
                alarm.add(!quiet);
                *confusion.entry((NOTHING.into(), said.into())).or_insert(0) += 1;
                quiet
            }
            [one] if one.outside_library => {
                let right = answer.verdict == "unknown-cause" && answer.places.first() == Some(&one.place);
                outside.add(right);
                *confusion.entry((format!("{} (no library)", one.kind), said.into())).or_insert(0) += 1;
                right
            }
            [one] => {
                let kinds: Vec<&str> = accepted.iter().map(|effect| effect.kind.as_str()).collect();
                let set = alike(answer, &kinds);
                let right = set.contains(&one.kind.as_str());
                place.add(answer.places.first() == Some(&one.place));
                first.add(right);
                let mut kinds: Vec<&str> = Vec::new();
                answer.effects.iter().for_each(|effect| {
                    if !kinds.contains(&effect.kind.as_str()) {
                        kinds.push(&effect.kind);
                    }
                });
                top3.add(kinds.iter().take(3).any(|kind| *kind == one.kind));
                // A cause that is named counts, also where more than noise is said to be left.
                let said = accepted.first().map_or(said, |effect| effect.kind.as_str());
                *confusion.entry((one.kind.clone(), said.into())).or_insert(0) += 1;
                closed.push(answer.claimed);
                right
            }
            several => {
                let right =
                    several.iter().all(|hidden| accepted.iter().any(|effect| effect.kind == hidden.kind));
                pair.add(right);
                closed.push(answer.claimed);
                right
            }
        };
        if let Some(closed) = answer.closed_held_back.filter(|_| !accepted.is_empty()) {
            claims.push((answer.claimed - closed).abs());
        }
        for effect in &answer.effects {
            stated.push((effect.probability, case.effects.iter().any(|hidden| hidden.kind == effect.kind)));
        }
        for hidden in &case.effects {
            let Some(found) = accepted.iter().find(|effect| effect.kind == hidden.kind) else { continue };
            for (name, value) in hidden.parameters.iter().filter(|(name, _)| *name != UNSCORED) {
                if let Some(fitted) = found.parameters.get(name) {
                    errors.push((fitted / value - 1.0).abs());
                }
                // A value that was not fitted has no interval.
                if let Some([low, high]) = found.intervals.get(name).filter(|[low, high]| high > low) {
                    inside.add((low..=high).contains(&value));
                }
            }
        }
        cases.push(CaseScore {
            case: case.case.clone(),
            hidden: case.effects.iter().map(|effect| effect.kind.clone()).collect(),
            answered: accepted.iter().map(|effect| effect.kind.clone()).collect(),
            verdict: answer.verdict.clone(),
            right,
        });
    }
    let reliability = reliability(&stated);
    let count = stated.len().max(1) as f64;
    let calibration_error = reliability
        .iter()
        .map(|bin| bin.count as f64 / count * (bin.mean_stated - bin.frequency).abs())
        .sum::<f64>();
    let middle = |what, mut values: Vec<f64>, wanted, reached: fn(f64) -> bool| {
        values.sort_by(f64::total_cmp);
        let value = values.get(values.len() / 2).copied();
        Measure { what, value, cases: values.len(), wanted, reached: value.is_some_and(reached) }
    };
    let measures = vec![
        place.measure("place right, single effect of the library", "at least 95 %", |x| x >= 0.95),
        first.measure("kind right at rank 1, look-alikes as a set of at most 3", "at least 90 %", |x| {
            x >= 0.9
        }),
        top3.measure("kind among the first 3", "", |_| true),
        alarm.measure("false alarm where nothing is hidden", "at most 2 %", |x| x <= 0.02),
        outside.measure("effect of no library: refused, place right", "at least 80 %", |x| x >= 0.8),
        pair.measure("both of two effects found", "at least 75 %", |x| x >= 0.75),
        middle("parameter error, median", errors, "at most 5 %", |x| x <= 0.05),
        inside.measure("true values inside their stated 90 % interval", "", |_| true),
        middle("share of the gap closed, median", closed, "at least 90 %", |x| x >= 0.9),
        middle("claimed against held-back closing, median difference", claims, "at most 10 %", |x| x <= 0.1),
        Measure {
            what: "expected calibration error of stated probabilities",
            value: (!stated.is_empty()).then_some(calibration_error),
            cases: stated.len(),
            wanted: "at most 10 %",
            reached: calibration_error <= 0.1,
        },
        middle("wall time of a diagnosis (s), median", times, "at most 60", |x| x <= 60.0),
    ];
    let mut confusion: Vec<(String, String, usize)> =
        confusion.into_iter().map(|((a, b), n)| (a, b, n)).collect();
    confusion.sort();
    let unanswered = truth.len() - cases.len();
    Score { measures, confusion, reliability, cases, unanswered }
}

/// The first kind with those declared to look like any that was accepted, where that makes no more than
/// [`MOST_ALIKE`].
fn alike<'a>(answer: &'a Answered, accepted: &[&'a str]) -> Vec<&'a str> {
    let Some(&first) = accepted.first() else { return Vec::new() };
    let mut set = vec![first];
    for [a, b] in &answer.look_alikes {
        for (one, other) in [(a, b), (b, a)] {
            if accepted.contains(&one.as_str()) && !set.contains(&other.as_str()) {
                set.push(other);
            }
        }
    }
    if set.len() > MOST_ALIKE { vec![first] } else { set }
}

fn reliability(stated: &[(f64, bool)]) -> Vec<Calibration> {
    (0..BINS)
        .filter_map(|i| {
            let edges = [i, i + 1].map(|edge| edge as f64 / BINS as f64);
            let is_last = i + 1 == BINS;
            let inside: Vec<_> =
                stated.iter().filter(|(p, _)| *p >= edges[0] && (*p < edges[1] || is_last)).collect();
            let n = inside.len();
            let mean = |sum: f64| sum / n as f64;
            (n > 0).then(|| Calibration {
                stated: edges,
                mean_stated: mean(inside.iter().map(|(p, _)| p).sum()),
                frequency: mean(inside.iter().filter(|(_, right)| *right).count() as f64),
                count: n,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::cases::HiddenEffect;
    use super::*;

    fn hidden(case: &str, kinds: &[&str], outside_library: bool) -> Case {
        let effect = |kind: &&str| HiddenEffect {
            kind: (*kind).into(),
            place: "guide".into(),
            parameters: IndexMap::from([("level".to_owned(), 10.0)]),
            outside_library,
        };
        Case {
            case: case.into(),
            effects: kinds.iter().map(effect).collect(),
            allowed: Vec::new(),
            conditions: None,
        }
    }

    fn answered(case: &str, verdict: &str, kinds: &[&str]) -> Answered {
        let effect = |kind: &&str| AnsweredEffect {
            kind: (*kind).into(),
            accepted: true,
            probability: 0.9,
            parameters: IndexMap::from([("level".to_owned(), 10.4)]),
            intervals: IndexMap::from([(
                "level".to_owned(),
                if case == "e" { [10.2, 10.6] } else { [9.8, 11.0] },
            )]),
        };
        Answered {
            case: case.into(),
            verdict: verdict.into(),
            places: vec!["guide".into()],
            effects: kinds.iter().map(effect).collect(),
            claimed: 0.95,
            closed_held_back: Some(0.93),
            ..Answered::default()
        }
    }

    fn value(score: &Score, what: &str) -> f64 {
        score.measures.iter().find(|measure| measure.what.starts_with(what)).unwrap().value.unwrap()
    }

    #[test]
    fn truth_right_and_wrong_answers_are_counted_by_kind_of_case() {
        let truth = [
            hidden("a", &["coulomb-friction"], false),
            hidden("b", &["command-delay"], false),
            hidden("c", &[], false),
            hidden("d", &["drag"], true),
            hidden("e", &["coulomb-friction", "force-bias"], false),
            hidden("not answered", &["force-bias"], false),
        ];
        let mut b = answered("b", "ambiguous", &["actuator-lag"]);
        b.look_alikes = vec![["actuator-lag".into(), "command-delay".into()]];
        let answers = [
            answered("a", "explained", &["coulomb-friction"]),
            b,
            answered("c", "explained", &["backlash"]),
            answered("d", "unknown-cause", &[]),
            answered("e", "explained", &["coulomb-friction"]),
        ];
        let score = score(&truth, &answers);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(close(value(&score, "kind right"), 1.0));
        assert!(close(value(&score, "kind among"), 0.5));
        assert!(close(value(&score, "false alarm"), 1.0));
        assert!(close(value(&score, "effect of no library"), 1.0));
        assert!(close(value(&score, "both of two"), 0.0));
        assert!(close(value(&score, "parameter error"), 0.04));
        // The level of 10 is found in two cases, in one of them inside its interval.
        assert!(close(value(&score, "true values inside"), 0.5));
        assert_eq!((score.cases.len(), score.unanswered), (5, 1));
        assert!(score.confusion.contains(&("nothing".into(), "backlash".into(), 1)));
        // Four causes stated with 0.9, of which two were hidden.
        let [bin] = score.reliability[..] else { panic!("one bin") };
        assert!(close(bin.frequency, 0.5) && bin.count == 4);
    }
}
