//! Scores: answers compared with hidden effects.

mod answered;
mod goals;
mod judge;
mod measures;
mod reliability;

use std::collections::BTreeMap;

use indexmap::IndexMap;

pub use answered::{
    Answered, AnsweredEffect, Calibration, CaseScore, Measure, MeasureUnit, NOTHING, Score, ScoredValue,
    UNKNOWN,
};
use goals::Goals;
use judge::Judged;
use measures::Tallies;

use super::cases::Case;
use super::regression::Regressed;

/// Scores answers, and the answers of a plain regression to the same cases. Cases without an answer are left
/// out.
pub fn score(truth: &[Case], answers: &[Answered], regressions: &BTreeMap<String, Vec<Regressed>>) -> Score {
    let mut tallies = Tallies::default();
    let mut confusion: IndexMap<(String, String), usize> = IndexMap::new();
    let mut cases = Vec::new();
    for case in truth {
        let Some(answer) = answers.iter().find(|answer| answer.case == case.case) else { continue };
        let judged = Judged::new(case, answer, regressions.get(&case.case).map_or(&[], Vec::as_slice));
        if let Some(pair) = judged.confused() {
            *confusion.entry(pair).or_insert(0) += 1;
        }
        tallies.add(&judged);
        cases.push(judged.summary());
    }
    let goals = Goals::of(truth);
    let reliability = reliability::bins(&tallies.stated);
    let measures = tallies.measures(&reliability, goals);
    let mut confusion: Vec<(String, String, usize)> =
        confusion.into_iter().map(|((a, b), n)| (a, b, n)).collect();
    confusion.sort();
    let unanswered = truth.len() - cases.len();
    Score { measures, confusion, reliability, cases, unanswered }
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
            servo: None,
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
        let score = score(&truth, &answers, &BTreeMap::new());
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(close(value(&score, "kind right"), 1.0));
        assert!(close(value(&score, "kind among"), 0.5));
        assert!(close(value(&score, "false alarm"), 1.0));
        assert!(close(value(&score, "effect of no library"), 1.0));
        assert!(close(value(&score, "both of two"), 0.0));
        assert!(close(value(&score, "parameter error"), 0.04));
        // A level of 10 is found in two cases. In one of them its interval contains the level.
        assert!(close(value(&score, "true values inside"), 0.5));
        assert_eq!((score.cases.len(), score.unanswered), (5, 1));
        assert!(score.confusion.contains(&("nothing".into(), "backlash".into(), 1)));
        // Four causes were stated with 0.9; two of them were hidden.
        let [bin] = score.reliability[..] else { panic!("one bin") };
        assert!(close(bin.frequency, 0.5) && bin.count == 4);
    }

    #[test]
    fn truth_explained_is_wrong_where_something_hidden_is_missed_or_something_else_is_accused() {
        let truth = [
            hidden("right", &["coulomb-friction"], false),
            hidden("alike", &["command-delay"], false),
            hidden("accused beside", &["coulomb-friction"], false),
            hidden("missed of two", &["coulomb-friction", "force-bias"], false),
            hidden("no library", &["drag"], true),
            hidden("wrong but unsure", &["coulomb-friction"], false),
            hidden("nothing", &[], false),
        ];
        let mut alike = answered("alike", "explained", &["actuator-lag"]);
        alike.look_alikes = vec![["actuator-lag".into(), "command-delay".into()]];
        let answers = [
            answered("right", "explained", &["coulomb-friction"]),
            alike,
            answered("accused beside", "explained", &["coulomb-friction", "force-limit"]),
            answered("missed of two", "explained", &["coulomb-friction"]),
            answered("no library", "explained", &["viscous-friction"]),
            answered("wrong but unsure", "ambiguous", &["force-limit"]),
            answered("nothing", "no-gap", &[]),
        ];
        let score = score(&truth, &answers, &BTreeMap::new());
        let sure: Vec<&str> =
            score.cases.iter().filter(|case| case.sure_and_wrong).map(|case| case.case.as_str()).collect();
        assert_eq!(sure, ["accused beside", "missed of two", "no library"]);
        assert!((value(&score, "\"explained\" but wrong") - 3.0 / 7.0).abs() < 1e-12);
    }

    #[test]
    fn truth_a_belief_that_is_off_may_be_named_and_need_not_be() {
        let allowed = |mut case: Case| {
            case.allowed = vec!["viscous-friction".into()];
            case
        };
        let truth = [
            allowed(hidden("named", &[], false)),
            allowed(hidden("not named", &[], false)),
            allowed(hidden("beside", &["coulomb-friction"], false)),
            allowed(hidden("in its place", &["coulomb-friction"], false)),
        ];
        let answers = [
            answered("named", "explained", &["viscous-friction"]),
            answered("not named", "no-gap", &[]),
            answered("beside", "explained", &["viscous-friction", "coulomb-friction"]),
            answered("in its place", "explained", &["viscous-friction"]),
        ];
        let score = score(&truth, &answers, &BTreeMap::new());
        let right: Vec<bool> = score.cases.iter().map(|case| case.right).collect();
        let sure: Vec<bool> = score.cases.iter().map(|case| case.sure_and_wrong).collect();
        assert_eq!((right, sure), (vec![true, true, true, false], vec![false, false, false, true]));
    }

    #[test]
    fn truth_the_place_of_a_named_belief_may_come_first() {
        let gain = |case: &str| {
            let mut gain = hidden(case, &["drive-gain"], false);
            gain.allowed = vec!["viscous-friction".into()];
            gain.effects[0].place = "drive".into();
            gain
        };
        let at = |places: &[&str], answer: Answered| Answered {
            places: places.iter().map(ToString::to_string).collect(),
            ..answer
        };
        let both = ["drive-gain", "viscous-friction"];
        for (places, kinds, expected) in [
            (["guide", "drive"], both.as_slice(), 1.0),
            (["guide", "drive"], &both[..1], 0.0),
            (["guide", "transmission"], &both, 0.0),
            (["transmission", "drive"], &both, 0.0),
        ] {
            let answers = [at(&places, answered("a", "explained", kinds))];
            let score = score(&[gain("a")], &answers, &BTreeMap::new());
            let found = value(&score, "place right");
            assert!((found - expected).abs() < f64::EPSILON, "{places:?} {kinds:?}: {found}");
        }
    }

    #[test]
    fn truth_the_regression_is_counted_beside_and_says_what_cannot_be_decided() {
        let truth = [
            hidden("a", &["coulomb-friction"], false),
            hidden("b", &["added-mass"], false),
            hidden("c", &["drive-gain"], false),
        ];
        let mut b = answered("b", "ambiguous", &["drive-gain"]);
        b.look_alikes = vec![["drive-gain".into(), "added-mass".into()]];
        b.free_run = Some([0.5, 0.6]);
        let mut c = answered("c", "explained", &["force-limit"]);
        c.free_run = Some([0.5, 0.1]);
        let answers = [answered("a", "explained", &["coulomb-friction"]), b, c];
        let ranking = |gains: &[(&str, f64)]| {
            let of = |(kind, gain): &(&str, f64)| Regressed {
                kind: (*kind).to_owned(),
                place: if *kind == "drive-gain" { "drive".into() } else { "guide".into() },
                gain: *gain,
            };
            gains.iter().map(of).collect::<Vec<_>>()
        };
        let regressions = BTreeMap::from([
            ("a".to_owned(), ranking(&[("coulomb-friction", 90.0), ("constant-load", 3.0)])),
            ("b".to_owned(), ranking(&[("drive-gain", 40.0), ("added-mass", 40.0)])),
            ("c".to_owned(), ranking(&[("drive-gain", 40.0), ("added-mass", 20.0)])),
        ]);
        let score = score(&truth, &answers, &regressions);
        let close = |what: &str, wanted: f64| assert!((value(&score, what) - wanted).abs() < 1e-12, "{what}");
        close("plain regression: kind", 2.0 / 3.0);
        close("plain regression: place", 1.0 / 3.0);
        // The second answer is right by its look-alike.
        close("diagnosis on the same cases: kind", 2.0 / 3.0);
        close("not decidable: the truth", 1.0 / 3.0);
        close("not decidable: kind named", 1.0);
        close("decidable: kind", 0.5);
        close("free run", 0.5);
        let measure =
            |what: &str| score.measures.iter().find(|measure| measure.what.starts_with(what)).unwrap();
        assert!(!measure("free run").reached && measure("free run").wanted == "never");
        assert!(measure("diagnosis on the same cases: kind").reached);
        assert_eq!(score.cases[1].regression.as_deref(), Some("drive-gain"));
    }
}
