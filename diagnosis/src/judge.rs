//! Compares sets of causes by evidence, simplicity and plausible values.

use feeler_plant::effects::Trait;

use crate::dataset::Dataset;
use crate::dataset::rattle::rattles;
use crate::fit::candidates::{Candidate, candidates};
use crate::fit::glance::glance;
use crate::fit::least_squares::Fitted;
use crate::fit::odds::{ACCEPT, ACCEPT_ALL, evidence, room};
use crate::fit::scored::Scored;
use crate::fit::search::{Search, extensions, finished, score};
use crate::gap::size::noise;
use crate::gap::unknown;
use crate::kinds::{contains, dossier};

/// Evidence on the check experiments that each of several causes needs to be kept, nats.
const KEEP: f64 = 12.0;
/// Evidence that a further cause needs, nats. A second cause may compensate for small errors of the first.
pub(crate) const ACCEPT_FURTHER: f64 = 40.0;
/// Evidence that a further cause needs on the check experiments alone, nats.
const ACCEPT_FURTHER_CHECK: f64 = 30.0;
/// A cause with more parameters is preferred to a simpler one only with this much more evidence, nats. Real
/// friction differs slightly from every law.
pub(crate) const PARSIMONY: f64 = 30.0;
/// This additional evidence if the accepted causes are plain numbers, which describe reality exactly: odds of
/// twenty to one.
const PARSIMONY_BESIDE_NUMBERS: f64 = 3.0;
/// Share by which a law must explain more than a simpler law that it contains.
const NESTED_SHARE: f64 = 0.15;
/// A set with plausible values replaces a best set with implausible ones if it has this share of the best
/// evidence.
const FAIR_SHARE: f64 = 0.6;
/// Causes whose evidence is within this of the best look alike in these records, nats.
pub(crate) const LOOK_ALIKE: f64 = 12.0;
/// Fit steps after an effect is removed.
const REMOVAL_STEPS: usize = 6;

/// All sets of causes that were tried or considered.
pub(crate) struct Attempts {
    /// Sets that were fitted fully.
    pub(crate) fitted: Vec<Scored>,
    /// Sets that were fitted for a few steps.
    pub(crate) screened: Vec<Scored>,
    /// Sets that were not fitted, because nothing in the records indicates the last of their causes.
    pub(crate) silent: Vec<Vec<Candidate>>,
    /// Sets that were not tried, because the time ran out before the last of their causes.
    pub(crate) untried: Vec<Vec<Candidate>>,
}

/// Evidence required of a further cause, nats.
pub(crate) struct Asked {
    pub(crate) check: f64,
    pub(crate) all: f64,
    /// Evidence on the check experiments that each cause needs to be kept.
    pub(crate) keep: f64,
    /// Additional evidence for a cause with more parameters.
    pub(crate) parsimony: f64,
}

impl Asked {
    /// The evidence required of a first cause.
    const FIRST: Self =
        Self { check: ACCEPT, all: ACCEPT_ALL, keep: ACCEPT, parsimony: PARSIMONY_BESIDE_NUMBERS };

    /// The evidence required of a set whose last cause is new. If that cause adds to a believed value at the
    /// limit of its tolerance, it needs no more evidence than a first cause.
    pub(crate) fn of(dataset: &Dataset, scored: &Scored, accepted: &Scored) -> Self {
        let frees = scored.causes.last().is_some_and(|cause| Self::frees(dataset, accepted, cause));
        if frees { Self::FIRST } else { Self::beside(accepted) }
    }

    /// Whether a cause adds to a believed value at the limit of its tolerance, or to the delay of commands at
    /// the late limit of their timing.
    fn frees(dataset: &Dataset, accepted: &Scored, cause: &Candidate) -> bool {
        let Fitted { model, theta, .. } = &accepted.fitted;
        let is_late = model.is_timing_at_limit(theta) && model.leeway(theta).late_rows > 0.0;
        if is_late && dataset.is_sampled_at(cause.site) && dossier(cause.definition.kind).is_late() {
            return true;
        }
        let excess =
            dossier(cause.definition.kind).adds_to.and_then(|key| model.excess(cause.site, key.name, theta));
        excess.is_some_and(|(_, is_at_limit)| is_at_limit)
    }

    /// The evidence required of a cause in addition to the accepted ones.
    pub(crate) fn beside(accepted: &Scored) -> Self {
        // A plain number describes reality exactly and leaves no error that a second cause could compensate
        // for. A second cause then needs no more evidence than a first.
        if accepted.causes.iter().all(|cause| cause.definition.has(Trait::PlainNumber)) {
            Self::FIRST
        } else {
            Self { check: ACCEPT_FURTHER_CHECK, all: ACCEPT_FURTHER, keep: KEEP, parsimony: PARSIMONY }
        }
    }
}

/// Magnitude of the position-dependent force of the first cause; `None` if it has none.
pub(crate) fn force_over_position(scored: &Scored) -> Option<f64> {
    let values = scored.fitted.model.parameters(0, &scored.fitted.theta);
    (dossier(scored.causes[0].definition.kind).force_over_position)(&values)
}

/// Moves the simplest of the sets that are nearly as good as the best to the front of a ranking.
pub(crate) fn prefer_simple<T: std::borrow::Borrow<Scored>>(
    ranked: &mut [T],
    parsimony: f64,
    evidence: impl Fn(&Scored) -> f64,
) {
    let Some(best) = ranked.first().map(|first| evidence(first.borrow())) else { return };
    let near = ranked.iter().take_while(|scored| best - evidence((*scored).borrow()) < parsimony).count();
    let simplest =
        (0..near).min_by_key(|&i| ranked[i].borrow().fitted.model.effect_parameters()).unwrap_or(0);
    ranked[..=simplest].rotate_right(1);
    // A law that contains a simpler one always gains slightly, because reality differs from both laws.
    let last = |scored: &Scored| scored.causes.last().map(|cause| (cause.site, cause.definition.kind));
    let Some((site, outer)) = last(ranked[0].borrow()) else { return };
    let inner = ranked.iter().position(|scored| {
        let scored = scored.borrow();
        let share = NESTED_SHARE * evidence(scored);
        last(scored).is_some_and(|(s, kind)| s == site && contains(outer, kind))
            && evidence(ranked[0].borrow()) - evidence(scored) < share
    });
    if let Some(i) = inner {
        ranked[..=i].rotate_right(1);
    }
}

/// A search, with the dataset that it used.
pub(crate) struct Judge<'a> {
    pub(crate) dataset: &'a Dataset,
    pub(crate) search: &'a Search<'a>,
    /// Weight of a balance of forces relative to predictions.
    pub(crate) weight: f64,
}

impl<'a> Judge<'a> {
    pub(crate) fn new(dataset: &'a Dataset, search: &'a Search<'a>) -> Self {
        let weight = search.task.inverse.as_ref().map_or(0.0, |inverse| inverse.weight);
        Self { dataset, search, weight }
    }
}

impl Judge<'_> {
    pub(crate) fn everything(&self) -> Vec<usize> {
        (0..self.dataset.records.len()).collect()
    }

    pub(crate) fn checks(&self) -> Vec<usize> {
        (0..self.dataset.records.len()).filter(|&r| self.dataset.records[r].is_check).collect()
    }

    pub(crate) fn all(&self, scored: &Scored) -> f64 {
        self.gain(&self.search.calibrated, scored, &self.everything())
    }

    /// Evidence for `new` over `old`; see [`evidence`].
    pub(crate) fn gain(&self, old: &Scored, new: &Scored, records: &[usize]) -> f64 {
        evidence(&self.search.task, old, new, records)
    }

    /// Whether a set of causes gains enough over another to justify its additional parameters.
    pub(crate) fn outweighs(&self, new: &Scored, old: &Scored) -> bool {
        let more = new.fitted.model.effect_parameters() > old.fitted.model.effect_parameters();
        let needed = if new.causes.len() > old.causes.len() {
            ACCEPT_FURTHER
        } else if more {
            PARSIMONY
        } else {
            0.0
        };
        self.all(new) - self.all(old) > needed
    }

    pub(crate) fn check(&self, old: &Scored, new: &Scored) -> f64 {
        self.gain(old, new, &self.checks())
    }

    /// Whether more than noise remains, and enough for a further cause.
    pub(crate) fn has_room(&self, accepted: &Scored) -> bool {
        let task = &self.search.task;
        let is_freed = |cause: &Candidate| Asked::frees(self.dataset, accepted, cause);
        let asked = if candidates(&self.dataset.machine).iter().any(is_freed) {
            Asked::FIRST
        } else {
            Asked::beside(accepted)
        };
        if task.weights.coarse.iter().any(|coarse| !coarse.is_seen_by(&accepted.causes)) {
            return true;
        }
        let [check, all] = room(task, accepted);
        let noise = || noise(task, &accepted.fitted.model, &accepted.fitted.theta);
        check >= asked.check && all >= asked.all && !unknown::is_quiet(task, accepted, &noise())
    }

    /// Moves the best set with plausible values to the front of a ranking, if it has a fair share of the
    /// first set's evidence.
    pub(crate) fn prefer_meant<T: std::borrow::Borrow<Scored>>(&self, ranked: &mut [T]) {
        let Some(most) = ranked.first().map(|first| self.all(first.borrow())) else { return };
        let meant = ranked.iter().position(|scored| self.is_meant(scored.borrow()));
        if let Some(i) = meant.filter(|&i| self.all(ranked[i].borrow()) > FAIR_SHARE * most) {
            ranked[..=i].rotate_right(1);
        }
    }

    pub(crate) fn is_acceptable(&self, scored: &Scored) -> bool {
        self.check(&self.search.calibrated, scored) > ACCEPT && self.all(scored) > ACCEPT_ALL
    }

    /// Replaces one cause by an equivalent pair. If the records cannot distinguish them, the pair is
    /// preferred.
    pub(crate) fn as_two(&self, accepted: &Scored) -> Option<Scored> {
        let [cause] = accepted.causes[..] else { return None };
        let [first, second] = dossier(cause.definition.kind).same_as?;
        let is_first = |single: &&Scored| {
            single.causes[0].site == cause.site && single.causes[0].definition.kind == first
        };
        let task = &self.search.task;
        let fitted = self.search.singles.iter().find(is_first).cloned();
        // Half of an effect may not have been fitted fully.
        let half = fitted.or_else(|| Some(finished(task, self.search.others.iter().find(is_first)?)))?;
        let second = candidates(&self.dataset.machine)
            .into_iter()
            .find(|c| c.site == cause.site && c.definition.kind == second)?;
        let pair = extensions(task, &half, &[second], &glance(task, &half)).fits.pop()?;
        (self.is_finding(&pair) && self.all(accepted) - self.all(&pair) < LOOK_ALIKE).then_some(pair)
    }

    /// Replaces a flexible joint by free play if the bodies hit each other, and returns the evidence for
    /// play. On average a joint with play is flexible too, and a flexible model predicts better. The instants
    /// of impacts depend on the unknown position within the play.
    pub(crate) fn as_play(&self, accepted: &Scored) -> Option<(Scored, String)> {
        let [cause] = accepted.causes[..] else { return None };
        let loose = dossier(cause.definition.kind).where_it_rattles?;
        if unknown::unexplained(&self.search.calibrated, accepted).is_empty() {
            return None;
        }
        let has_play = |scored: &&Scored| {
            scored.causes[0].definition.kind == loose && scored.causes[0].place == cause.place
        };
        let evidence = rattles(self.dataset)?;
        let loose = self.search.singles.iter().find(has_play).cloned();
        let loose =
            loose.or_else(|| Some(finished(&self.search.task, self.search.others.iter().find(has_play)?)))?;
        self.is_finding(&loose).then_some((loose, evidence))
    }

    /// Removes causes without which the set is about as good.
    pub(crate) fn prune(&self, mut scored: Scored, keep: impl Fn(&Candidate) -> f64) -> Scored {
        let mut i = 0;
        while i < scored.causes.len() && scored.causes.len() > 1 {
            let without = self.without(&scored, i);
            if self.check(&without, &scored) < keep(&scored.causes[i]) {
                scored = without;
                i = 0;
            } else {
                i += 1;
            }
        }
        scored
    }

    pub(crate) fn without(&self, scored: &Scored, effect: usize) -> Scored {
        let (model, keep) = scored.fitted.model.without(effect);
        let start: Vec<f64> = keep.iter().map(|&i| scored.fitted.theta[i]).collect();
        let fitted = self.search.task.fit(&model, &start, REMOVAL_STEPS);
        let mut causes = scored.causes.clone();
        causes.remove(effect);
        score(&self.search.task, causes, fitted)
    }
}
