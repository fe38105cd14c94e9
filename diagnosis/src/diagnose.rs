//! The diagnosis: calibrates, tries causes, composes and judges the answer.

use feeler_plant::effects::Trait;

use crate::budget::{Budget, Stage};
use crate::dataset::Dataset;
use crate::dataset::rattle::rattles;
use crate::error::DiagnosisError;
use crate::fit::candidates::{Candidate, candidates};
use crate::fit::glance::glance;
use crate::fit::least_squares::Fitted;
use crate::fit::odds::{ACCEPT, ACCEPT_ALL, gain, room};
use crate::fit::scored::Scored;
use crate::fit::search::{Extended, Search, extensions, finished, score, search};
use crate::gap::size::noise;
use crate::gap::unknown;
use crate::kinds::{Element, contains, dossier, overlaps};
use crate::report::Diagnosis;

/// Evidence on the check experiments below which one of several causes is removed again, nats.
const KEEP: f64 = 12.0;
/// Evidence that a further cause must bring, nats. A second cause can patch small errors of the first.
const ACCEPT_FURTHER: f64 = 40.0;
/// The same on the check experiments alone, which are fewer.
const ACCEPT_FURTHER_CHECK: f64 = 30.0;
/// A simpler cause is preferred unless one with more parameters brings at least this much more, nats: real
/// friction differs slightly from every law.
pub(crate) const PARSIMONY: f64 = 30.0;
/// The same if the accepted causes are plain numbers, which match reality exactly: odds of twenty to one.
const PARSIMONY_BESIDE_NUMBERS: f64 = 3.0;
/// Share by which a law must improve on a simpler one that it contains.
const NESTED_SHARE: f64 = 0.15;
/// If the best has implausible values, one with plausible values replaces it. It must bring this share of the
/// best one's evidence.
const FAIR_SHARE: f64 = 0.6;
/// Smallest part of an effect beyond the limit of the believed value that it adds to, over the part within.
const LEAST_REST: f64 = 0.1;
/// Largest number of causes in an answer.
const MOST_CAUSES: usize = 3;
/// Causes within this much evidence of the best look alike to these records, nats.
pub(crate) const LOOK_ALIKE: f64 = 12.0;
/// Fit steps after an effect is removed.
const REMOVAL_STEPS: usize = 6;

/// Finds where the gap between a machine and its records lies, what causes it, and how far it closes.
///
/// Calls `progress` with a description of each stage.
///
/// # Errors
/// If the described machine has no motion or no finite one, or if no experiments are left to fit or to check.
pub fn diagnose(dataset: &Dataset, progress: &dyn Fn(&str)) -> Result<Diagnosis, DiagnosisError> {
    diagnose_within(dataset, Budget::unlimited(), progress)
}

/// The same within a time budget. Returns the best answer found, with the causes that were not tried.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_within(
    dataset: &Dataset,
    budget: Budget,
    progress: &dyn Fn(&str),
) -> Result<Diagnosis, DiagnosisError> {
    let checked = dataset.records.iter().filter(|record| record.is_check).count();
    let fitted = dataset.records.len() - checked;
    if fitted == 0 || checked == 0 {
        return Err(DiagnosisError::Roles { fitted, checked });
    }
    progress("calibrating and trying single causes");
    let found = search(dataset, budget, |task, calibrated| {
        let [check, all] = room(task, calibrated);
        check >= ACCEPT && all >= ACCEPT_ALL
    })?;
    let judge = Judge::new(dataset, &found);
    // Only causes that could be accepted by themselves may be preferred for their simplicity.
    let mut ranked: Vec<&Scored> = found
        .singles
        .iter()
        .filter(|scored| judge.is_finding(scored) && judge.is_acceptable(scored))
        .collect();
    ranked.sort_by(|a, b| judge.all(b).total_cmp(&judge.all(a)));
    prefer_simple(&mut ranked, PARSIMONY, |scored| judge.all(scored));
    judge.prefer_meant(&mut ranked);
    let mut attempts = Attempts {
        fitted: found.singles.clone(),
        screened: found.others.clone(),
        silent: Vec::new(),
        untried: Vec::new(),
    };
    attempts.silent.extend(found.silent.iter().map(|candidate| vec![*candidate]));
    attempts.untried.extend(found.untried.iter().map(|candidate| vec![*candidate]));
    let mut accepted = found.calibrated.clone();
    let mut rivals: Vec<Scored> = Vec::new();
    if let Some(best) = ranked.first() {
        accepted = (*best).clone();
        rivals = ranked.iter().map(|scored| (*scored).clone()).collect();
        if let Some(pair) = judge.as_two(&accepted) {
            rivals.insert(0, pair.clone());
            attempts.fitted.push(pair.clone());
            accepted = pair;
        }
    }
    // The missing force depends on position, but no effect of the library makes it. A sine too long for a
    // ripple describes it better than any cause.
    let shapes = found.singles.iter().filter(|scored| !judge.is_finding(scored));
    let shape = (shapes.filter_map(|scored| Some((scored, force_over_position(scored)?))))
        .max_by(|(a, _), (b, _)| judge.all(a).total_cmp(&judge.all(b)));
    if let Some((_, force)) =
        shape.filter(|(shape, _)| judge.gain(&accepted, shape, &judge.everything()) > ACCEPT_FURTHER)
    {
        return Ok(judge.position_force(force, &attempts));
    }
    if let Some((loose, evidence)) = judge.as_play(&accepted) {
        if !attempts
            .fitted
            .iter()
            .any(|tried| tried.causes.len() == 1 && tried.causes[0].is(&loose.causes[0]))
        {
            attempts.fitted.push(loose.clone());
        }
        // The residual after unpredictable impacts is no evidence of a further cause.
        let mut answer = judge.answer(&loose, std::slice::from_ref(&loose), &attempts);
        answer
            .places
            .iter_mut()
            .filter(|place| place.place == loose.causes[0].place.name())
            .for_each(|place| place.evidence.clone_from(&evidence));
        return Ok(answer);
    }
    let glimpse = glance(&found.task, &accepted);
    while !accepted.causes.is_empty() && accepted.causes.len() < MOST_CAUSES && judge.has_room(&accepted) {
        let left: Vec<_> = candidates(&dataset.machine)
            .into_iter()
            .filter(|c| {
                !accepted
                    .causes
                    .iter()
                    .any(|a| a.site == c.site && overlaps(a.definition.kind, c.definition.kind))
            })
            .collect();
        let beside =
            |candidate: Candidate| accepted.causes.iter().copied().chain([candidate]).collect::<Vec<_>>();
        if budget.is_over(Stage::Screen) {
            attempts.untried.extend(left.into_iter().map(beside));
            break;
        }
        progress("trying a further cause");
        let Extended { fits: mut further, others, silent, untried } =
            extensions(&found.task, &accepted, &left, &glimpse);
        attempts.fitted.extend(further.iter().cloned());
        attempts.screened.extend(others);
        attempts.silent.extend(silent.into_iter().map(beside));
        attempts.untried.extend(untried.into_iter().map(beside));
        let asked = |scored: &Scored| Asked::of(scored, &accepted);
        let enough = |scored: &Scored| {
            let asked = asked(scored);
            judge.check(&accepted, scored) >= asked.check
                && judge.gain(&accepted, scored, &judge.everything()) >= asked.all
        };
        further.retain(|scored| judge.is_finding(scored) && enough(scored));
        further.sort_by(|a, b| judge.all(b).total_cmp(&judge.all(a)));
        let parsimony = Asked::beside(&accepted).parsimony;
        prefer_simple(&mut further, parsimony, |scored| judge.all(scored));
        judge.prefer_meant(&mut further);
        let Some(best) = further.first() else { break };
        let beside = Asked::beside(&accepted).keep;
        let last = best.causes.last().copied();
        let pruned = judge.prune(best.clone(), |cause| {
            let is_last = last.is_some_and(|last| last.is(cause));
            if is_last { asked(best).keep } else { beside }
        });
        // If a cause adds nothing beside a partner, the partner keeps its own rivals. A combination that
        // contains the partner is no rival.
        if pruned.causes.iter().all(|cause| accepted.causes.iter().any(|known| known.is(cause))) {
            // On the way the same causes may have been fitted better.
            if pruned.causes.len() == accepted.causes.len() && pruned.fitted.cost < accepted.fitted.cost {
                accepted = pruned;
            }
            break;
        }
        if pruned.causes.len() > accepted.causes.len() {
            rivals = further;
        }
        accepted = pruned;
    }
    let pairs = judge.proposed_pairs();
    attempts.fitted.extend(pairs.iter().cloned());
    if let Some(best) = pairs.first()
        && judge.check(&found.calibrated, best) > ACCEPT
        && judge.outweighs(best, &accepted)
    {
        let keep = Asked::beside(&found.calibrated).keep;
        let pruned = judge.prune(best.clone(), |_| keep);
        rivals = pairs.iter().filter(|pair| pair.causes.len() == pruned.causes.len()).cloned().collect();
        rivals.push(accepted);
        accepted = pruned;
    }
    if accepted.causes.len() > 1 {
        accepted = judge.simplified(accepted);
        let exchanged = judge.exchanged(&accepted);
        attempts.fitted.extend(exchanged.iter().cloned());
        rivals.extend(exchanged);
    }
    progress("weighing the answer");
    let answer = judge.answer(&accepted, &rivals, &attempts);
    if answer.gap.before.is_finite() && answer.gap.refit.is_finite() {
        Ok(answer)
    } else {
        Err(DiagnosisError::Unbounded {
            spacing_s: dataset.records.iter().map(|record| record.spacing_s).fold(0.0, f64::max),
        })
    }
}

/// All causes that were tried or considered.
pub(crate) struct Attempts {
    /// Fitted to the end.
    pub(crate) fitted: Vec<Scored>,
    /// Fitted for a few steps.
    pub(crate) screened: Vec<Scored>,
    /// Not fitted: nothing in the records suggests the last of these causes.
    pub(crate) silent: Vec<Vec<Candidate>>,
    /// Not tried: the time ran out before the last of these causes.
    pub(crate) untried: Vec<Vec<Candidate>>,
}

/// Evidence required of a further cause, nats.
struct Asked {
    check: f64,
    all: f64,
    /// On the check experiments, for each cause that stays.
    keep: f64,
    /// Additional evidence that a cause with more parameters must bring.
    parsimony: f64,
}

impl Asked {
    /// No more than of a first cause.
    const FIRST: Self =
        Self { check: ACCEPT, all: ACCEPT_ALL, keep: ACCEPT, parsimony: PARSIMONY_BESIDE_NUMBERS };

    /// Of a set of causes, the last of which is new beside those accepted before. If the last adds to a
    /// believed value that ends at the limit of its tolerance, it must bring no more than a first.
    fn of(scored: &Scored, accepted: &Scored) -> Self {
        let frees = scored.causes.last().is_some_and(|cause| Self::frees(accepted, cause));
        if frees { Self::FIRST } else { Self::beside(accepted) }
    }

    /// Whether a cause adds to a believed value that ends at the limit of its tolerance.
    fn frees(accepted: &Scored, cause: &Candidate) -> bool {
        let Fitted { model, theta, .. } = &accepted.fitted;
        let excess =
            dossier(cause.definition.kind).adds_to.and_then(|key| model.excess(cause.site, key.name, theta));
        excess.is_some_and(|(_, is_at_limit)| is_at_limit)
    }

    /// The evidence required beside the accepted causes.
    fn beside(accepted: &Scored) -> Self {
        // A plain number describes reality exactly, so that a second cause has no error to patch. It needs no
        // more evidence than a first.
        if accepted.causes.iter().all(|cause| cause.definition.has(Trait::PlainNumber)) {
            Self::FIRST
        } else {
            Self { check: ACCEPT_FURTHER_CHECK, all: ACCEPT_FURTHER, keep: KEEP, parsimony: PARSIMONY }
        }
    }
}

/// Size of the force over position that the first cause describes; `None` if it describes none.
fn force_over_position(scored: &Scored) -> Option<f64> {
    let values = scored.fitted.model.parameters(0, &scored.fitted.theta);
    (dossier(scored.causes[0].definition.kind).force_over_position)(&values)
}

/// Moves the simplest of those nearly as good as the best to the front of a ranking.
fn prefer_simple<T: std::borrow::Borrow<Scored>>(
    ranked: &mut [T],
    parsimony: f64,
    evidence: impl Fn(&Scored) -> f64,
) {
    let Some(best) = ranked.first().map(|first| evidence(first.borrow())) else { return };
    let near = ranked.iter().take_while(|scored| best - evidence((*scored).borrow()) < parsimony).count();
    let simplest =
        (0..near).min_by_key(|&i| ranked[i].borrow().fitted.model.effect_parameters()).unwrap_or(0);
    ranked[..=simplest].rotate_right(1);
    // A law that contains a simpler one always gains slightly, because reality differs from both.
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

/// A search, with the data that it was made on.
pub(crate) struct Judge<'a> {
    pub(crate) dataset: &'a Dataset,
    pub(crate) search: &'a Search<'a>,
    /// Weight of a balance of forces against predictions.
    pub(crate) weight: f64,
    /// Ratio of independent samples in all experiments to those in the check experiments.
    looks: f64,
}

impl<'a> Judge<'a> {
    fn new(dataset: &'a Dataset, search: &'a Search<'a>) -> Self {
        let task = &search.task;
        let weight = task.inverse.as_ref().map_or(0.0, |inverse| inverse.weight);
        let of = |is_counted: &dyn Fn(usize) -> bool| {
            let counted = task.weights.looks.iter().enumerate().filter(|(r, _)| is_counted(*r));
            counted.map(|(_, looks)| looks.iter().copied().fold(0.0, f64::max)).sum::<f64>()
        };
        let looks = of(&|_| true) / of(&|r| dataset.records[r].is_check).max(1.0);
        Self { dataset, search, weight, looks }
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

    /// Evidence for one set of causes against another over some records. It counts predictions, and the
    /// balance of forces if that shows both.
    pub(crate) fn gain(&self, old: &Scored, new: &Scored, records: &[usize]) -> f64 {
        let predicted = gain(&self.search.task.weights, old, new, records);
        let (Some(old), Some(new)) = (&old.balanced, &new.balanced) else { return predicted };
        let is_all = records.iter().any(|&r| !self.dataset.records[r].is_check);
        let balanced = if is_all { self.looks } else { 1.0 } * (new.nats - old.nats);
        (1.0 - self.weight) * predicted + self.weight * balanced
    }

    /// Whether a set of causes gains enough over another to justify its additional parameters.
    fn outweighs(&self, new: &Scored, old: &Scored) -> bool {
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

    /// Whether more than noise remains, and enough of it for a further cause.
    fn has_room(&self, accepted: &Scored) -> bool {
        let task = &self.search.task;
        let is_freed = |cause: &Candidate| Asked::frees(accepted, cause);
        let asked = if candidates(&self.dataset.machine).iter().any(is_freed) {
            Asked::FIRST
        } else {
            Asked::beside(accepted)
        };
        let [check, all] = room(task, accepted);
        let noise = || noise(task, &accepted.fitted.model, &accepted.fitted.theta);
        check >= asked.check && all >= asked.all && !unknown::is_quiet(task, accepted, &noise())
    }

    /// Moves the best set with plausible values to the front of a ranking, if it explains a fair share of
    /// what the first does.
    fn prefer_meant<T: std::borrow::Borrow<Scored>>(&self, ranked: &mut [T]) {
        let Some(most) = ranked.first().map(|first| self.all(first.borrow())) else { return };
        let meant = ranked.iter().position(|scored| self.is_meant(scored.borrow()));
        if let Some(i) = meant.filter(|&i| self.all(ranked[i].borrow()) > FAIR_SHARE * most) {
            ranked[..=i].rotate_right(1);
        }
    }

    fn is_acceptable(&self, scored: &Scored) -> bool {
        self.check(&self.search.calibrated, scored) > ACCEPT && self.all(scored) > ACCEPT_ALL
    }

    pub(crate) fn is_finding(&self, scored: &Scored) -> bool {
        let Fitted { model, theta, .. } = &scored.fitted;
        scored.causes.iter().enumerate().all(|(i, cause)| {
            let element = Element::at(cause.site, &model.believed, &self.dataset.tolerance);
            let known = dossier(cause.definition.kind);
            let mut values = model.parameters(i, theta);
            // What the calibrated value took over belongs to the effect.
            let taken = known.adds_to.and_then(|key| model.excess(cause.site, key.name, theta));
            let is_rest = taken.is_some_and(|(excess, limit)| limit && values[0] < LEAST_REST * excess);
            values[0] += taken.map_or(0.0, |(excess, _)| excess);
            !is_rest
                && !model.is_believed(i, theta)
                && !(known.is_trivial)(&values, &element, self.search.seen)
        })
    }

    /// Replaces one cause by the two that together have the same effect. If the records cannot distinguish
    /// them, the two are preferred.
    fn as_two(&self, accepted: &Scored) -> Option<Scored> {
        let [cause] = accepted.causes[..] else { return None };
        let [first, second] = dossier(cause.definition.kind).same_as?;
        let first = self.search.singles.iter().find(|single| {
            single.causes[0].site == cause.site && single.causes[0].definition.kind == first
        })?;
        let second = candidates(&self.dataset.machine)
            .into_iter()
            .find(|c| c.site == cause.site && c.definition.kind == second)?;
        let pair =
            extensions(&self.search.task, first, &[second], &glance(&self.search.task, first)).fits.pop()?;
        (self.is_finding(&pair) && self.all(accepted) - self.all(&pair) < LOOK_ALIKE).then_some(pair)
    }

    /// Replaces a flexible joint by free play if the bodies hit each other. Returns the evidence too. On
    /// average a joint with play also bends, and a model that bends predicts more safely than impacts do. The
    /// instants of impacts depend on where in the play a body stands.
    fn as_play(&self, accepted: &Scored) -> Option<(Scored, String)> {
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

    /// Removes effects whose removal costs nothing.
    fn prune(&self, mut scored: Scored, keep: impl Fn(&Candidate) -> f64) -> Scored {
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
