//! Compares sets of causes by evidence, simplicity and plausible values.

use feeler_plant::description::Site;
use feeler_plant::effects::{Kind, LIBRARY, Parameter, Trait};

use crate::dataset::Dataset;
use crate::dataset::rattle::rattles;
use crate::fit::candidates::{Candidate, candidates};
use crate::fit::least_squares::Fitted;
use crate::fit::odds::{ACCEPT, ACCEPT_ALL, evidence, room, room_above_noise};
use crate::fit::scored::Scored;
use crate::fit::search::{Search, finished, score};
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
/// A set with possible values replaces a best set with impossible ones if it has this share of the best
/// evidence.
const FAIR_SHARE: f64 = 0.6;
/// Causes whose evidence is within this of the best look alike in these records, nats.
pub(crate) const LOOK_ALIKE: f64 = 12.0;
/// Fit steps after an effect is removed.
const REMOVAL_STEPS: usize = 6;

/// All sets of causes that were tried or considered.
#[derive(Default)]
pub(crate) struct Attempts {
    /// Sets that were fitted fully.
    pub(crate) fitted: Vec<Scored>,
    /// Sets that were fitted for a few steps.
    pub(crate) screened: Vec<Scored>,
    /// Sets that were not fitted, because nothing in the records indicates the last of their causes.
    pub(crate) silent: Vec<Vec<Candidate>>,
    /// Sets that were not tried, because the time ran out before the last of their causes.
    pub(crate) untried: Vec<Vec<Candidate>>,
    /// Sets whose fits the end of the time cut short.
    pub(crate) unfinished: Vec<Vec<Candidate>>,
    /// Whether the end of the time left pairs or exchanges untried.
    pub(crate) is_cut: bool,
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
        if model.is_timing_at_late_limit(theta)
            && dataset.is_sampled_at(cause.site)
            && dossier(cause.definition.kind).is_late()
        {
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
    let values = scored.values(0);
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
        let is_enough = |[check, all]: [f64; 2]| check >= asked.check && all >= asked.all;
        let noise = || noise(task, &accepted.fitted.model, &accepted.fitted.theta);
        is_enough(room(task, accepted))
            && !unknown::is_quiet(task, accepted, &noise())
            && is_enough(room_above_noise(task, accepted))
    }

    /// Moves the best set with possible values to the front of a ranking, if it has a fair share of the
    /// first set's evidence.
    pub(crate) fn prefer_possible<T: std::borrow::Borrow<Scored>>(&self, ranked: &mut [T]) {
        let Some(most) = ranked.first().map(|first| self.all(first.borrow())) else { return };
        let possible = ranked.iter().position(|scored| self.is_possible(scored.borrow()));
        if let Some(i) = possible.filter(|&i| self.all(ranked[i].borrow()) > FAIR_SHARE * most) {
            ranked[..=i].rotate_right(1);
        }
    }

    /// Moves the first set whose last cause extends a limit of `base` to the front of a ranking. The limit is
    /// that of a tolerance or of the timing of commands. The set must look like the best one: a value beyond
    /// its tolerance needs no new law.
    pub(crate) fn prefer_freed<T: std::borrow::Borrow<Scored>>(&self, ranked: &mut [T], base: &Scored) {
        let most = ranked.iter().map(|scored| self.all(scored.borrow())).fold(f64::NEG_INFINITY, f64::max);
        let frees = |scored: &Scored| {
            scored.causes.last().is_some_and(|cause| Asked::frees(self.dataset, base, cause))
                && most - self.all(scored) < LOOK_ALIKE
        };
        if let Some(i) = ranked.iter().position(|scored| frees(scored.borrow())) {
            ranked[..=i].rotate_right(1);
        }
    }

    pub(crate) fn is_acceptable(&self, scored: &Scored) -> bool {
        self.check(&self.search.calibrated, scored) > ACCEPT && self.all(scored) > ACCEPT_ALL
    }

    /// Replaces a cause by the two causes whose sum it is. They predict the same, so they are preferred. If
    /// one of them is believed, the other remains.
    pub(crate) fn split(&self, accepted: &Scored) -> Option<Scored> {
        let is_sum = |cause: &Candidate| dossier(cause.definition.kind).parts.is_some();
        let i = accepted.causes.iter().position(is_sum)?;
        let (sum, values) = (accepted.causes[i], accepted.values(i));
        let known = dossier(sum.definition.kind);
        let new = known.parts?.into_iter().zip((known.split)(&values)?);
        let split = self.replaced(accepted, sum.site, &[i], &new.collect::<Vec<_>>())?;
        (self.is_finding(&split) && self.all(accepted) - self.all(&split) < LOOK_ALIKE).then_some(split)
    }

    /// Replaces two causes by the one that is their sum, and predicts the same.
    pub(crate) fn merged(&self, accepted: &Scored) -> Option<Scored> {
        LIBRARY.iter().find_map(|sum| {
            let known = dossier(sum.kind);
            let [first, second] = known.parts?;
            let is = |cause: &Candidate, kind: Kind| cause.definition.kind == kind;
            let i = accepted.causes.iter().position(|cause| is(cause, first))?;
            let site = accepted.causes[i].site;
            let j = accepted.causes.iter().position(|cause| is(cause, second) && cause.site == site)?;
            let values = (known.merge)([&accepted.values(i), &accepted.values(j)])?;
            self.replaced(accepted, site, &[i, j], &[(sum.kind, values)])
        })
    }

    /// The causes without `gone`, and with new ones on an element; `None` if values are out of range. A new
    /// cause that equals a believed effect within its tolerance is that effect.
    fn replaced(
        &self,
        scored: &Scored,
        site: Site,
        gone: &[usize],
        new: &[(Kind, Vec<f64>)],
    ) -> Option<Scored> {
        let all = candidates(&self.dataset.machine);
        let Fitted { model: old, theta: values, .. } = &scored.fitted;
        let (mut model, mut theta, mut causes) = (old.clone(), values.clone(), scored.causes.clone());
        let mut gone = gone.to_vec();
        gone.sort_unstable();
        for i in gone.into_iter().rev() {
            let (without, keep) = model.without(i);
            theta = keep.iter().map(|&kept| theta[kept]).collect();
            model = without;
            causes.remove(i);
        }
        let is_new = |(kind, values): &&(Kind, Vec<f64>)| !model.believes(site, *kind, values);
        let (new, believed): (Vec<_>, Vec<_>) = new.iter().partition(is_new);
        for (kind, values) in new {
            let cause = all.iter().find(|cause| cause.site == site && cause.definition.kind == *kind)?;
            let is_within = |(value, parameter): (&f64, &Parameter)| {
                (parameter.bounds.0..=parameter.bounds.1).contains(value)
            };
            if !values.iter().zip(cause.definition.parameters).all(is_within) {
                return None;
            }
            model = model.with(site, cause.definition, values);
            causes.push(*cause);
        }
        if causes.is_empty() {
            return None;
        }
        let mut start = model.start();
        start[..theta.len()].copy_from_slice(&theta);
        // The presliding of the old law is that of the new one.
        model.take_over(&mut start, old, values, 0);
        for (kind, values) in believed {
            model.believe(&mut start, site, *kind, values);
        }
        let task = &self.search.task;
        Some(score(task, causes, task.fit(&model, &start, REMOVAL_STEPS)))
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

    /// Whether the only accepted cause is a free play whose impacts the records show. Predictions do not
    /// follow impacts, so neither errors of predictions nor intervals speak against it.
    pub(crate) fn is_play(&self, accepted: &Scored) -> bool {
        let [cause] = accepted.causes[..] else { return false };
        LIBRARY.iter().any(|one| dossier(one.kind).where_it_rattles == Some(cause.definition.kind))
            && self.is_finding(accepted)
            && rattles(self.dataset).is_some()
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

    /// The set without one cause, fitted again: the calibrated machine if it is the only one.
    pub(crate) fn without(&self, scored: &Scored, effect: usize) -> Scored {
        if scored.causes.len() == 1 {
            return self.search.calibrated.clone();
        }
        let (model, keep) = scored.fitted.model.without(effect);
        let start: Vec<f64> = keep.iter().map(|&i| scored.fitted.theta[i]).collect();
        let fitted = self.search.task.fit(&model, &start, REMOVAL_STEPS);
        let mut causes = scored.causes.clone();
        causes.remove(effect);
        score(&self.search.task, causes, fitted)
    }
}

#[cfg(test)]
mod tests {
    use feeler_files::Document;
    use feeler_plant::assembly::Source;

    use super::*;
    use crate::budget::Budget;
    use crate::dataset::{Channel, Driven, Record};
    use crate::fit::search::search;

    const JOINT: &str = "[bodies.motor]\nmass = 1.0\n[bodies.tip]\nmass = 0.5\n[springs.guide]\n\
        between = [\"ground\", \"motor\"]\ndamping = 10.0\n[springs.joint]\nbetween = [\"motor\", \"tip\"]\n\
        rigid = true\n[sensors.motor]\nreads = \"motor.acceleration\"\n[sensors.tip]\n\
        reads = \"tip.acceleration\"\n[actuators.drive]\non = \"motor\"\nkind = \"force\"\n";

    /// Accelerations of motor and tip, which differ in rare blows or in a sine.
    fn shaken(has_blows: bool) -> Dataset {
        let machine = Document::parse(JOINT, "joint.toml").unwrap().scenario.machine;
        let channels = ["motor", "tip"].into_iter().enumerate().map(|(i, name)| Channel {
            column: name.into(),
            source: Source::Sensor(i),
            noise: 1e-3,
            resolution: 0.0,
        });
        let drives = vec![Driven { drive: 0, column: "u".into(), hold_s: Some(1e-3), noise: None }];
        let record = |i: u8| {
            let command: Vec<f64> = (0..500).map(|k| 8.0 * (0.02 * f64::from(k)).sin()).collect();
            let own: Vec<f64> = command.iter().map(|u| u / 1.5).collect();
            let blow = |k: usize| if k.is_multiple_of(50) { 5.0 } else { 0.0 };
            let differs = |k: usize| if has_blows { blow(k) } else { (0.3 * k as f64).sin() };
            let tip = own.iter().enumerate().map(|(k, a)| a + differs(k)).collect();
            let record = Record::even(format!("{i}.csv"), 1e-3, vec![command], vec![own, tip]);
            Record { is_check: i % 2 == 1, ..record }
        };
        Dataset::new("joint", machine, drives, channels.collect(), (0..4).map(record).collect())
    }

    /// Predictions do not follow impacts, so a free play stays although it improves none.
    #[test]
    fn truth_only_impacts_show_a_free_play() {
        let set = |dataset: &Dataset, kind: Kind, values: &[f64]| {
            let found = search(dataset, Budget::unlimited(), &|_| {}, |_, _| false).unwrap();
            let all = candidates(&dataset.machine);
            let cause = *all.iter().find(|one| one.definition.kind == kind).unwrap();
            let model = found.calibrated.fitted.model.with(cause.site, cause.definition, values);
            let fitted = Fitted { theta: model.start(), model, ..found.calibrated.fitted.clone() };
            let scored = Scored { causes: vec![cause], fitted, ..found.calibrated.clone() };
            Judge::new(dataset, &found).is_play(&scored)
        };
        let [blows, sine] = [true, false].map(shaken);
        // A width of 0.1 mm with stiff flanks.
        assert!(set(&blows, Kind::Backlash, &[1e-4, 1e6, 10.0]));
        assert!(!set(&sine, Kind::Backlash, &[1e-4, 1e6, 10.0]));
        assert!(!set(&blows, Kind::ViscousFriction, &[5.0]));
    }
}
