//! Compares one answer with the truth.

use super::super::cases::{Case, HiddenEffect};
use super::super::regression::{Regressed, named};
use super::answered::{Answered, AnsweredEffect, CaseScore, NOTHING, ScoredValue, UNKNOWN};

/// Largest number of look-alike kinds that count as one answer.
const MOST_ALIKE: usize = 3;
/// Parameter that is not scored, because angles must be compared on the circle.
const UNSCORED: &str = "phase";
/// Place of all believed values that an answer may name.
const BELIEVED_AT: &str = "guide";
/// Verdicts that claim no effect.
const QUIET: [&str; 2] = ["no-gap", "not-identifiable"];

/// The effects that a case hides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Hides<'a> {
    Nothing,
    NoLibrary(&'a HiddenEffect),
    One(&'a HiddenEffect),
    Several(&'a [HiddenEffect]),
}

/// An answer compared with the truth.
pub(super) struct Judged<'a> {
    pub(super) case: &'a Case,
    pub(super) answer: &'a Answered,
    pub(super) hides: Hides<'a>,
    /// Accepted effects, without those that an answer may name although they are not hidden.
    pub(super) accepted: Vec<&'a AnsweredEffect>,
    /// Findings of the plain regression, the best first.
    pub(super) regression: &'a [Regressed],
}

impl<'a> Judged<'a> {
    pub(super) fn new(case: &'a Case, answer: &'a Answered, regression: &'a [Regressed]) -> Self {
        let hides = match case.effects.as_slice() {
            [] => Hides::Nothing,
            [one] if one.outside_library => Hides::NoLibrary(one),
            [one] => Hides::One(one),
            several => Hides::Several(several),
        };
        let counts = |effect: &&AnsweredEffect| {
            effect.accepted && (hidden(case, &effect.kind) || !case.allowed.contains(&effect.kind))
        };
        let accepted = answer.effects.iter().filter(counts).collect();
        Self { case, answer, hides, accepted, regression }
    }

    fn is_unknown(&self) -> bool {
        self.answer.verdict == "unknown-cause"
    }

    fn kinds(&self) -> Vec<&'a str> {
        self.accepted.iter().map(|effect| effect.kind.as_str()).collect()
    }

    /// Whether the first place is that of a hidden effect. The place of a believed value that is off may come
    /// before it, if the answer names that value.
    pub(super) fn place_is(&self, hidden: &HiddenEffect) -> bool {
        let may_come_first = hidden.place != BELIEVED_AT && self.names_belief();
        let mut places =
            self.answer.places.iter().skip_while(|place| may_come_first && *place == BELIEVED_AT);
        places.next() == Some(&hidden.place)
    }

    /// Whether the answer accepts a believed value that is off as a cause.
    fn names_belief(&self) -> bool {
        let is_belief = |kind: &String| self.case.allowed.contains(kind) && !hidden(self.case, kind);
        self.answer.effects.iter().any(|effect| effect.accepted && is_belief(&effect.kind))
    }

    /// Whether the answer is right by the measure for the hidden effects.
    pub(super) fn is_right(&self) -> bool {
        match self.hides {
            Hides::Nothing => {
                self.accepted.is_empty()
                    && (self.names_belief() || QUIET.contains(&self.answer.verdict.as_str()))
            }
            Hides::NoLibrary(one) => self.is_unknown() && self.place_is(one),
            Hides::One(one) => self.alike().contains(&one.kind.as_str()),
            Hides::Several(several) => {
                several.iter().all(|hidden| self.accepted.iter().any(|effect| effect.kind == hidden.kind))
            }
        }
    }

    /// Whether the answer says `explained` and is wrong, which has two cases. A hidden effect is neither
    /// named nor a declared look-alike of a named effect. Or a named effect is neither hidden nor a declared
    /// look-alike of a hidden one.
    pub(super) fn is_sure_and_wrong(&self) -> bool {
        let is_accused =
            |kind: &&str| !self.case.effects.iter().any(|hidden| self.are_alike(kind, &hidden.kind));
        self.answer.verdict == "explained"
            && (!self.names_all_or_alike() || self.kinds().iter().any(is_accused))
    }

    /// Whether every hidden effect is named, or a declared look-alike of it.
    pub(super) fn names_all_or_alike(&self) -> bool {
        let kinds = self.kinds();
        let is_named = |hidden: &HiddenEffect| {
            !hidden.outside_library && kinds.iter().any(|kind| self.are_alike(kind, &hidden.kind))
        };
        self.case.effects.iter().all(is_named)
    }

    /// Whether two kinds are equal or declared alike.
    fn are_alike(&self, a: &str, b: &str) -> bool {
        let pairs = &self.answer.look_alikes;
        a == b || pairs.iter().any(|[x, y]| (x == a && y == b) || (x == b && y == a))
    }

    /// Whether the kind is among the first three that the answer names.
    pub(super) fn is_among_first_three(&self, one: &HiddenEffect) -> bool {
        let mut kinds: Vec<&str> = Vec::new();
        for effect in &self.answer.effects {
            if !kinds.contains(&effect.kind.as_str()) {
                kinds.push(&effect.kind);
            }
        }
        kinds.iter().take(3).any(|kind| *kind == one.kind)
    }

    /// Whether the kind is named, as accepted, as a rival or as a look-alike.
    pub(super) fn is_named_at_all(&self, one: &HiddenEffect) -> bool {
        self.answer.effects.iter().any(|effect| effect.kind == one.kind)
            || self.answer.look_alikes.iter().flatten().any(|kind| *kind == one.kind)
    }

    /// Whether the regression with the true cause gains no more on the check experiments than with the best
    /// other cause. `None` unless one effect is hidden and the regression ranks that effect.
    pub(super) fn is_undecidable(&self) -> Option<bool> {
        let Hides::One(one) = self.hides else { return None };
        let own = self.regression.iter().find(|regressed| regressed.kind == one.kind)?.gain;
        let others = self.regression.iter().filter(|regressed| regressed.kind != one.kind);
        let best = others.map(|regressed| regressed.gain).fold(0.0, f64::max);
        Some(own <= best)
    }

    /// Hidden and answered kind; `None` for cases with several hidden effects.
    pub(super) fn confused(&self) -> Option<(String, String)> {
        let first = self.accepted.first().map(|effect| effect.kind.clone());
        let said = match &first {
            _ if self.is_unknown() => UNKNOWN.to_owned(),
            Some(kind) => kind.clone(),
            None => NOTHING.to_owned(),
        };
        match self.hides {
            Hides::Nothing => Some((NOTHING.to_owned(), said)),
            Hides::NoLibrary(one) => Some((format!("{} (no library)", one.kind), said)),
            // A named cause counts, even if the answer reports an unknown rest.
            Hides::One(one) => Some((one.kind.clone(), first.unwrap_or(said))),
            Hides::Several(_) => None,
        }
    }

    pub(super) fn summary(&self) -> CaseScore {
        CaseScore {
            case: self.case.case.clone(),
            hidden: self.case.effects.iter().map(|effect| effect.kind.clone()).collect(),
            answered: self.kinds().into_iter().map(str::to_owned).collect(),
            verdict: self.answer.verdict.clone(),
            right: self.is_right(),
            sure_and_wrong: self.is_sure_and_wrong(),
            regression: named(self.regression).map(|regressed| regressed.kind.clone()),
            values: self.values(),
        }
    }

    /// The parameters of the hidden effects that were found.
    pub(super) fn values(&self) -> Vec<ScoredValue> {
        let found = |hidden: &'a HiddenEffect| {
            let found = *self.accepted.iter().find(|effect| effect.kind == hidden.kind)?;
            let parameters = hidden.parameters.iter().filter(|(name, _)| *name != UNSCORED);
            Some(parameters.map(move |(name, value)| ScoredValue {
                kind: hidden.kind.clone(),
                parameter: name.clone(),
                hidden: *value,
                fitted: found.parameters.get(name).copied(),
                interval: found.intervals.get(name).copied(),
            }))
        };
        self.case.effects.iter().filter_map(found).flatten().collect()
    }

    /// The first accepted kind, with the declared look-alikes of all accepted kinds unless they exceed
    /// [`MOST_ALIKE`].
    fn alike(&self) -> Vec<&'a str> {
        let accepted = self.kinds();
        let Some(&first) = accepted.first() else { return Vec::new() };
        let mut set = vec![first];
        for [a, b] in &self.answer.look_alikes {
            for (one, other) in [(a, b), (b, a)] {
                if accepted.contains(&one.as_str()) && !set.contains(&other.as_str()) {
                    set.push(other);
                }
            }
        }
        if set.len() > MOST_ALIKE { vec![first] } else { set }
    }
}

fn hidden(case: &Case, kind: &str) -> bool {
    case.effects.iter().any(|effect| effect.kind == kind)
}
