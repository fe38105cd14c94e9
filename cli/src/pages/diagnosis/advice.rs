//! Steps to take after a diagnosis, and the limits of its answer.

use feeler_diagnosis::apart;
use feeler_diagnosis::report::{Cause, Diagnosis, MOST_ODDS, Verdict};
use feeler_plant::effects::Kind;
use serde::Serialize;

use super::adequacy;
use super::words::{estimate, is_limited, is_only_early, is_slight, parameters, sentence};
use crate::numbers::{percent, plain};

/// Recommendations from the answer.
pub(crate) struct Advice {
    /// Steps to take, in this order; a sentence or two each.
    pub(crate) steps: Vec<String>,
    /// Limits of the answer, a sentence each.
    pub(crate) remarks: Vec<String>,
}

impl Advice {
    pub(crate) fn of(diagnosis: &Diagnosis) -> Self {
        let correct = |fault: &String| format!("Correct the records: {fault}.");
        let mut steps: Vec<String> = diagnosis.contradictions.iter().map(correct).collect();
        if !steps.is_empty() {
            steps.push("Diagnose again. Only if the corrected records agree, do what follows.".into());
        }
        steps.extend(longer(diagnosis));
        steps.extend(as_unit(diagnosis));
        steps.extend(to_do(diagnosis));
        let mut remarks = adequacy::reasons(&diagnosis.adequacy);
        for [a, b] in &diagnosis.look_alikes {
            if diagnosis.verdict == Verdict::UnknownCause {
                remarks.push(format!(
                    "{a} and {b} look alike in these records. Neither explains them, so separating them \
                     would not find the cause."
                ));
                continue;
            }
            remarks.push(format!("{a} and {b} look alike in these records."));
            if diagnosis.next_experiment.is_none() {
                match apart(*a, *b) {
                    Some(what) => steps.push(format!("To separate {a} from {b}, {what}.")),
                    None => remarks.push(format!(
                        "No known command separates {a} from {b} within the travel and speed of these \
                         records."
                    )),
                }
            }
        }
        remarks.extend(diagnosis.presliding.iter().map(|guide| {
            format!(
                "Before it slides, {} yields: stiffness {}, damping ratio {}.",
                guide.on,
                estimate(&guide.stiffness),
                estimate(&guide.damping_ratio)
            )
        }));
        remarks.extend(diagnosis.left.iter().map(|left| format!("Still unexplained: {left}.")));
        if let Some(next) = &diagnosis.next_experiment {
            steps.push(format!(
                "Next experiment: {} It separates {} from {}, with expected odds of {}; the command is in \
                 next-experiment.csv.",
                sentence(&next.what),
                next.separates[0],
                next.separates[1],
                odds(next.expected_odds)
            ));
        }
        Self { steps, remarks }
    }
}

/// A diagnosis as programs read it: with the steps to take. The book shows the comments.
#[derive(Serialize)]
pub(crate) struct Advised<'a> {
    /// The answer.
    #[serde(flatten)]
    diagnosis: &'a Diagnosis,
    /// Steps to take, in this order.
    what_to_do: Vec<String>,
}

impl<'a> Advised<'a> {
    pub(crate) fn of(diagnosis: &'a Diagnosis) -> Self {
        Self { diagnosis, what_to_do: Advice::of(diagnosis).steps }
    }
}

/// The step if causes, or a table in place of a cause, were left untried: a longer search.
fn longer(diagnosis: &Diagnosis) -> Option<String> {
    let longer = "Diagnose again with a larger --budget, or with --budget unlimited.";
    let why = if diagnosis.adequacy.has_untried() {
        "Until then do not rely on a cause."
    } else if diagnosis.adequacy.has_untried_table() {
        "It tries a table of the missing force, which can stand in for the cause."
    } else {
        return None;
    };
    Some(format!("{longer} {why}"))
}

/// The step for a gain of a drive: wrong units of its column are the same.
fn as_unit(diagnosis: &Diagnosis) -> Option<String> {
    let gain = diagnosis.effects.iter().find(|effect| effect.accepted && effect.kind == Kind::DriveGain)?;
    Some(format!(
        "First check the unit of the command of {}: a current in place of a force or torque shows as the \
         same gain.",
        gain.on
    ))
}

/// Recommendations for the machine.
fn to_do(diagnosis: &Diagnosis) -> Vec<String> {
    let table = diagnosis.table.as_ref().map(|table| {
        format!(
            "Until the cause is known, simulate with machine.toml. A table of the force over {} on {} stands \
             in for it, and closes {} % of the gap on the check experiments.",
            table.over,
            table.on,
            percent(table.closed)
        )
    });
    let words = match diagnosis.verdict {
        Verdict::Explained => {
            let found = diagnosis.effects.iter().filter(|effect| effect.accepted);
            let inspect = |cause: &Cause| {
                format!(
                    "On the real machine, inspect {} for {}, {}.",
                    cause.on,
                    cause.kind,
                    parameters(cause)
                )
            };
            let simulate = "Simulate with the repaired machine.toml.".to_owned();
            return std::iter::once(simulate).chain(found.map(inspect)).collect();
        }
        // Before the longer search nothing else is worth doing.
        Verdict::UnknownCause if diagnosis.adequacy.has_untried() => return table.into_iter().collect(),
        Verdict::Ambiguous if is_only_early(diagnosis) => return table.into_iter().collect(),
        Verdict::NotIdentifiable if diagnosis.adequacy.may_hide_cause() => {
            "Use the calibrated values of machine.toml. Record or state what is named below, and diagnose \
             again: it then shows whether a cause is hidden."
        }
        Verdict::NotIdentifiable if diagnosis.adequacy.is_doubted() => {
            "Use the calibrated values of machine.toml. State `hold` or correct the believed value, as named \
             below, and diagnose again: it then shows whether a cause is hidden."
        }
        Verdict::Ambiguous if is_limited(diagnosis) => {
            "Correct the believed value named below, or state a wider tolerance, and diagnose again."
        }
        Verdict::Ambiguous | Verdict::NotIdentifiable => {
            match (&diagnosis.next_experiment, diagnosis.look_alikes.is_empty()) {
                (Some(_), _) => {
                    "Run the experiment below and diagnose again. Until then machine.toml is one of several \
                     that fit."
                }
                (None, true) => {
                    "Record with more excitation and diagnose again. Until then machine.toml is one of \
                     several that fit."
                }
                (None, false) => {
                    "Simulate with machine.toml: it predicts these records as well as its rivals would. Do \
                     not rely on its cause before an experiment separates them."
                }
            }
        }
        Verdict::UnknownCause => {
            "Inspect the first place and the shape of the missing force there. No value of the machine file \
             removes this force within its tolerance."
        }
        Verdict::NoGap if is_slight(diagnosis) || diagnosis.adequacy.has_untried() => {
            "Use the calibrated values of machine.toml."
        }
        Verdict::NoGap => "Use the calibrated values of machine.toml. These records show no further cause.",
    };
    std::iter::once(words.to_owned()).chain(table).collect()
}

/// Odds against one, capped at a million.
fn odds(odds: f64) -> String {
    if odds >= MOST_ODDS { "more than a million to 1".into() } else { format!("{} to 1", plain(odds)) }
}

#[cfg(test)]
mod tests {
    use feeler_diagnosis::adequacy::{Adequacy, Condition, Shortfall};
    use feeler_diagnosis::report::Gap;
    use feeler_plant::description::Machine;
    use feeler_plant::effects::Kind;
    use indexmap::IndexMap;

    use super::*;

    #[test]
    fn truth_odds_that_are_cut_off_are_no_figure() {
        assert_eq!(odds(1e6), "more than a million to 1");
        assert_eq!(odds(12.5), "12.5 to 1");
    }

    /// An answer with one accepted cause that falls short of these conditions.
    fn answer(verdict: Verdict, conditions: &[Condition]) -> Diagnosis {
        let short = |condition: &Condition| Shortfall { condition: *condition, what: String::new() };
        let mut adequacy = Adequacy::default();
        adequacy.shortfalls = conditions.iter().map(short).collect();
        let found = Cause {
            kind: Kind::CoulombFriction,
            on: "springs.guide".into(),
            place: "guide",
            probability: 1.0,
            parameters: IndexMap::new(),
            credit: 1.0,
            accepted: true,
        };
        Diagnosis {
            verdict,
            gap: Gap::default(),
            adequacy,
            places: Vec::new(),
            effects: vec![found],
            look_alikes: Vec::new(),
            presliding: Vec::new(),
            attempts: Vec::new(),
            next_experiment: None,
            cells: Vec::new(),
            ladder: Vec::new(),
            missing_force_n: [0.0; 2],
            left: Vec::new(),
            table: None,
            noise: IndexMap::new(),
            warnings: Vec::new(),
            contradictions: Vec::new(),
            inverse: Vec::new(),
            machine: Machine::default(),
            calibrated: Machine::default(),
        }
    }

    /// Terminal and page print the same steps.
    #[test]
    fn truth_the_first_step_is_a_longer_search_if_causes_or_a_table_were_left_untried() {
        for verdict in [
            Verdict::Explained,
            Verdict::Ambiguous,
            Verdict::UnknownCause,
            Verdict::NoGap,
            Verdict::NotIdentifiable,
        ] {
            let steps = |conditions: &[Condition]| {
                let answer = answer(verdict, conditions);
                let json = serde_json::to_value(Advised::of(&answer)).unwrap();
                let steps = Advice::of(&answer).steps;
                assert_eq!(json["what_to_do"], serde_json::json!(steps), "{verdict:?}");
                assert!(json["verdict"].is_string(), "{json}");
                steps
            };
            let all = steps(&[Condition::Rivals]);
            let names = |steps: &[String]| steps.iter().filter(|step| step.contains("--budget")).count();
            for left in [Condition::Tried, Condition::Table] {
                let cut = steps(&[Condition::Rivals, left]);
                assert!(cut[0].contains("larger --budget") && names(&cut) == 1, "{verdict:?}: {cut:?}");
            }
            assert_eq!(names(&all), 0, "{verdict:?}: {all:?}");
        }
    }

    #[test]
    fn truth_an_answer_that_only_lacks_time_names_no_rivals() {
        let (early, rivalled) = (
            answer(Verdict::Ambiguous, &[Condition::Tried]),
            answer(Verdict::Ambiguous, &[Condition::Tried, Condition::Rivals]),
        );
        let [early_said, rivalled_said] = [&early, &rivalled].map(super::super::words::verdict);
        assert!(early_said.contains("the time ended") && !early_said.contains("rivals"), "{early_said}");
        assert!(rivalled_said.contains("rivals"), "{rivalled_said}");
        assert_eq!([early, rivalled].map(|answer| Advice::of(&answer).steps.len()), [1, 2]);
    }
}
