//! The causes of an answer: how probable each is, its values, and which causes look alike.

use feeler_plant::description::{Axis, ElementKind};
use feeler_plant::effects::{Kind, LIBRARY, Parameter, Scale};
use feeler_plant::units::Dimension;
use indexmap::IndexMap;

use crate::answer::intervals;
use crate::budget::Stage;
use crate::fit::candidates::Candidate;
use crate::fit::least_squares::Fitted;
use crate::fit::odds::{gain, probabilities};
use crate::fit::sandwich::{self, Deviations};
use crate::fit::scored::{Scored, distinct};
use crate::judge::{Judge, LOOK_ALIKE, PARSIMONY};
use crate::kinds::{contains, dossier, embed, nearest};
use crate::report::{Cause, Estimate};

/// Quantile of the 90 % interval of a normal distribution, in standard deviations.
pub(super) const NINETY_PERCENT: f64 = 1.645;
/// Ratio of Student's quantile with eleven degrees of freedom to the normal one. Deviations come from a dozen
/// blocks of motion or more (Cameron and Miller 2015, section VI). Whether a cause may be absent is decided
/// with cautious deviations, which are wider already.
pub(super) const OF_BLOCKS: f64 = 1.796 / NINETY_PERCENT;
/// Divisor of the evidence that softens the odds.
const TEMPERATURE: f64 = 4.0;
/// The divisor if only positions are measured: model errors and noise are then harder to separate.
const SLOW_TEMPERATURE: f64 = 12.0;
/// Largest probability of a cause that was accepted before another one.
const EARLIER: f64 = 0.95;
/// Largest probability of a cause that may be absent: on a wild seed 5 of 11 were right.
const MAYBE_ABSENT: f64 = 0.5;
/// Smallest odds of a set of causes that is listed.
const LEAST_ODDS: f64 = 0.005;
/// Total probability of the listed rivals.
const CREDIBLE: f64 = 0.99;
/// Levels of friction that differ by less than this share count as one level.
const ONE_LEVEL: f64 = 0.05;
/// Largest number of kinds that are reported as alike.
const MOST_ALIKE: usize = 2;

/// The accepted set of causes among its rivals.
pub(super) struct Field {
    /// The rivals, with the accepted set among them, by falling evidence; empty if there are no rivals.
    pub(super) sets: Vec<Scored>,
    /// Evidence for each, nats.
    pub(super) evidence: Vec<f64>,
    /// Odds of each.
    odds: Vec<f64>,
    /// Odds of the accepted set.
    pub(super) own: f64,
}

impl Field {
    /// Odds of all sets that hold a cause.
    fn marginal(&self, cause: &Candidate) -> f64 {
        let holds = |(set, _): &(&Scored, &f64)| set.causes.iter().any(|own| own.is(cause));
        let held: f64 = self.sets.iter().zip(&self.odds).filter(holds).map(|(_, p)| p).sum();
        if self.sets.is_empty() { 1.0 } else { held }
    }

    /// Odds of the sets that hold a cause at a place, and none of the accepted causes there.
    pub(super) fn instead(&self, accepted: &Scored, place: &str) -> f64 {
        let is_there = |cause: &&Candidate| cause.place.name() == place;
        let own: Vec<&Candidate> = accepted.causes.iter().filter(is_there).collect();
        let holds = |rival: &Scored| {
            rival.causes.iter().any(|cause| is_there(&cause))
                && !rival.causes.iter().any(|cause| own.iter().any(|own| own.is(cause)))
        };
        self.rivals(accepted).filter(|(rival, ..)| holds(rival)).map(|(_, p, _)| p).sum()
    }

    /// The sets that differ from the accepted one, with their odds and evidence.
    fn rivals<'f>(&'f self, accepted: &'f Scored) -> impl Iterator<Item = (&'f Scored, f64, f64)> {
        let all = self.sets.iter().zip(&self.odds).zip(&self.evidence);
        all.map(|((rival, p), e)| (rival, *p, *e)).filter(|(rival, ..)| !rival.is_same(accepted))
    }
}

impl Judge<'_> {
    /// Weighs the accepted set of causes against its rivals.
    pub(super) fn field(&self, accepted: &Scored, rivals: &[Scored]) -> Field {
        let is_other = |rival: &&Scored| !is_the_same_elsewhere(accepted, rival) && !rival.is_same(accepted);
        let mut sets: Vec<Scored> = rivals.iter().filter(is_other).cloned().collect();
        // Two causes and their sum predict the same. Their fits differ by how far each converged.
        let merged = self.merged(accepted);
        sets.extend(merged.iter().cloned());
        if !sets.is_empty() || !rivals.is_empty() {
            sets.push(accepted.clone());
        }
        let is_equal = |set: &Scored| merged.as_ref().is_some_and(|merged| merged.is_same(set));
        let evidence = |set: &Scored| {
            if is_equal(set) { self.all(accepted) } else { self.evidence_for(accepted, set) }
        };
        sets.sort_by(|a, b| evidence(b).total_cmp(&evidence(a)));
        // The same causes may have been fitted twice.
        let sets = distinct(sets);
        let evidence: Vec<f64> = sets.iter().map(evidence).collect();
        let weighed: Vec<f64> =
            sets.iter().zip(&evidence).map(|(set, own)| self.weighed(accepted, set, *own)).collect();
        let odds = probabilities(&weighed, if self.weight > 0.0 { SLOW_TEMPERATURE } else { TEMPERATURE });
        let own = sets.iter().zip(&odds).find(|(set, _)| set.is_same(accepted)).map_or(1.0, |(_, p)| *p);
        Field { sets, evidence, odds, own }
    }

    /// Evidence for a rival. Predictions alone separate a lag from a delay: a balance of forces sees both in
    /// friction at reversals, which it knows too roughly.
    fn evidence_for(&self, accepted: &Scored, rival: &Scored) -> f64 {
        let is_late = |beyond: Vec<(usize, &Candidate)>| match beyond[..] {
            [(_, cause)] => dossier(cause.definition.kind).is_late(),
            _ => false,
        };
        if is_late(accepted.beyond(rival)) && is_late(rival.beyond(accepted)) {
            let weights = &self.search.task.weights;
            self.all(accepted) + gain(weights, accepted, rival, &self.everything())
        } else {
            self.all(rival)
        }
    }

    /// Evidence for a rival, with the same corrections as in the selection. A rival with more parameters than
    /// the accepted causes must improve the prediction more. A law that contains an accepted law always
    /// predicts slightly better, so its evidence is at most that of the accepted set.
    fn weighed(&self, accepted: &Scored, rival: &Scored, evidence: f64) -> f64 {
        let parameters = |scored: &Scored| scored.fitted.model.effect_parameters();
        let more = if parameters(rival) > parameters(accepted) { PARSIMONY } else { 0.0 };
        let weighed = evidence - more;
        if is_outer(accepted, rival) { weighed.min(self.all(accepted)) } else { weighed }
    }

    /// Standard deviations of the fitted values by the correlation of residuals. If no time is left to
    /// measure it, those of the fit, which are mostly wider. Rivals always have those of the fit.
    pub(super) fn deviations(&self, accepted: &Scored) -> Deviations {
        let task = &self.search.task;
        let fitted = &accepted.fitted.sigma;
        let is_early = !task.budget.is_over(Stage::Compose);
        let measured = is_early.then(|| sandwich::deviations(task, &accepted.fitted)).flatten();
        measured.unwrap_or_else(|| Deviations { stated: fitted.clone(), cautious: fitted.clone() })
    }

    /// The accepted causes that may be absent, in words.
    pub(super) fn maybe_absent(&self, accepted: &Scored, sigma: &[f64]) -> Vec<String> {
        let of = |(i, cause): (usize, &Candidate)| {
            let name = cause.definition.parameters.first()?.name;
            let kind = cause.definition.kind;
            let may_be_zero = format!("{name} of {kind} may be zero: the cause may be absent");
            let counted = format!("with a hundred readings per record, {may_be_zero}");
            self.is_maybe_absent(accepted, i, sigma).then_some(counted)
        };
        accepted.causes.iter().enumerate().filter_map(of).collect()
    }

    /// The cause of several that is most likely absent; `None` if the interval of no size includes that of an
    /// absent cause.
    pub(crate) fn most_likely_absent(&self, accepted: &Scored) -> Option<usize> {
        let sigma = self.deviations(accepted).cautious;
        let reach = |i: &usize| self.reach_of_null(accepted, *i, &sigma).unwrap_or(0.0);
        let all = 0..accepted.causes.len();
        // A fit without time for a step knows no deviations.
        let is_late = self.search.task.budget.is_over(Stage::Compose);
        let is_known = |i: &usize| !is_late || reach(i).is_finite();
        all.filter(is_known).max_by(|a, b| reach(a).total_cmp(&reach(b))).filter(|i| reach(i) > 1.0)
    }

    /// Whether the interval of the size of cause `i` includes that of an absent cause, by cautious
    /// deviations. Evidence counts many stretches of a residual as independent, this interval does not.
    fn is_maybe_absent(&self, accepted: &Scored, i: usize, sigma: &[f64]) -> bool {
        self.reach_of_null(accepted, i, sigma).is_some_and(|reach| reach > 1.0)
    }

    /// Half of the 90 % interval of cause `i` over the distance to an absent cause, by the parameter that
    /// tells them apart best; `None` if no parameter does.
    fn reach_of_null(&self, accepted: &Scored, i: usize, sigma: &[f64]) -> Option<f64> {
        let parameters = accepted.causes[i].definition.parameters;
        let null = |k: usize| {
            let zero = Some(0.0).filter(|_| k == 0 && parameters[k].scale == Scale::Log);
            parameters[k].null.filter(|null| null.is_finite()).or(zero)
        };
        let reach = |k: usize| {
            let null = null(k)?;
            let (value, half) = self.interval(accepted, i, k, sigma);
            Some(half / (value - null).abs())
        };
        (0..parameters.len()).filter_map(reach).min_by(f64::total_cmp)
    }

    /// Value of parameter `k` of cause `i`, and half of its 90 % interval.
    fn interval(&self, scored: &Scored, i: usize, k: usize, sigma: &[f64]) -> (f64, f64) {
        let Fitted { model, theta, .. } = &scored.fitted;
        let value = model.parameters(i, theta)[k];
        let unknown = model.unknown_of(i, k);
        let deviation = unknown.map_or(0.0, |u| model.unknowns[u].spread(theta[u], sigma[u]));
        let spacing_s = self.dataset.records[0].spacing_s;
        let widened = intervals::widened(&scored.causes, i, k, value, deviation, spacing_s);
        (value, NINETY_PERCENT * widened)
    }

    /// The accepted causes, with the deviations `sigma` of all values, then those of rivals. `known` is the
    /// probability that the true causes are among these. `tried` holds all sets that were fitted.
    pub(super) fn causes(
        &self,
        accepted: &Scored,
        field: &Field,
        (known, sigma): (f64, &Deviations),
        tried: &[Scored],
    ) -> Vec<Cause> {
        let is_near = |set: &&Scored| {
            let evidence = self.evidence_for(accepted, set);
            self.is_finding(set) && self.weighed(accepted, set, evidence) > self.all(accepted) - LOOK_ALIKE
        };
        let near: Vec<&Scored> = tried.iter().filter(is_near).collect();
        let without_gain = self.without_gain(accepted);
        let mut causes: Vec<Cause> = (accepted.causes.iter().enumerate())
            .map(|(i, cause)| {
                // Only the last cause was compared with every other one.
                let most = match i + 1 == accepted.causes.len() {
                    _ if self.is_maybe_absent(accepted, i, &sigma.cautious) => MAYBE_ABSENT,
                    true => 1.0,
                    false => EARLIER,
                };
                let found = self.cause(accepted, i, &sigma.stated, known * field.marginal(cause).min(most));
                let mut found = Cause { accepted: true, ..covering(found, cause, &near) };
                if let Some(theta) = without_gain.as_ref().filter(|_| mass_instead(cause).is_none()) {
                    reaching(&mut found, &accepted.fitted.model.parameters(i, theta));
                }
                found
            })
            .collect();
        let mut listed: Vec<&Candidate> = Vec::new();
        let mut sum = field.own;
        for (rival, p, _) in field.rivals(accepted) {
            if sum < CREDIBLE && p > LEAST_ODDS {
                for (i, cause) in rival.beyond(accepted) {
                    if !listed.iter().any(|other| other.is(cause)) {
                        listed.push(cause);
                        let sigma = &rival.fitted.sigma;
                        causes.push(self.cause(rival, i, sigma, known * field.marginal(cause)));
                    }
                }
            }
            sum += p;
        }
        causes
    }

    /// A gain below one and an added mass, if these records determine only ratios of forces. Then only the
    /// masses relate the forces to the believed machine.
    pub(super) fn gain_or_mass(&self, accepted: &Scored) -> Option<[Kind; 2]> {
        let (model, theta) = (&accepted.fitted.model, &accepted.fitted.theta);
        let mut causes = accepted.causes.iter().enumerate();
        let (gain, mass) = causes.find_map(|(i, cause)| Some((i, mass_instead(cause)?)))?;
        if *model.parameters(gain, theta).first()? >= 1.0 {
            return None;
        }
        let scale = self.search.task.shared_scale(model, theta)?;
        scale.is_of_masses(model).then_some([accepted.causes[gain].definition.kind, mass])
    }

    /// Values that give the same prediction with all forces scaled up and a gain of one, if an added mass may
    /// replace an accepted gain.
    fn without_gain(&self, accepted: &Scored) -> Option<Vec<f64>> {
        self.gain_or_mass(accepted)?;
        let (model, theta) = (&accepted.fitted.model, &accepted.fitted.theta);
        let scale = self.search.task.shared_scale(model, theta)?;
        let gain = accepted.causes.iter().position(|cause| mass_instead(cause).is_some())?;
        let gain_of = |theta: &[f64]| model.parameters(gain, theta).first().copied();
        let more = scale.moved(model, theta, 1.0);
        let per_unit = (gain_of(&more)? / gain_of(theta)?).ln();
        let by = -gain_of(theta)?.ln() / per_unit;
        by.is_finite().then(|| scale.moved(model, theta, by))
    }

    /// Unit of a parameter of a cause.
    pub(super) fn unit_of(&self, cause: &Candidate, parameter: &Parameter) -> String {
        let machine = &self.dataset.machine;
        let drive = (cause.site.table == ElementKind::Actuators).then_some(cause.site.index);
        let drive = drive.and_then(|i| machine.actuators.get_index(i));
        let command = drive.map_or(Dimension::FORCE, |(_, actuator)| actuator.kind.command());
        let dimension = cause.definition.dimension_of(parameter, command);
        dimension.si_unit(machine.axis == Axis::Rotational).into_owned()
    }

    /// A cause of a fitted set with its values and their intervals.
    fn cause(&self, scored: &Scored, i: usize, sigma: &[f64], probability: f64) -> Cause {
        let candidate = scored.causes[i];
        let mut parameters = IndexMap::new();
        for (k, parameter) in candidate.definition.parameters.iter().enumerate() {
            let (value, half) = self.interval(scored, i, k, sigma);
            let half = half * OF_BLOCKS;
            let unit = self.unit_of(&candidate, parameter);
            let ci90 = intervals::within(parameter, value, half);
            parameters.insert(parameter.name, Estimate { value, ci90, unit });
        }
        Cause {
            kind: candidate.definition.kind,
            on: candidate.site.key(&self.dataset.machine),
            place: candidate.place.name(),
            probability,
            parameters,
            credit: 0.0,
            accepted: false,
        }
    }
}

/// Extends intervals to further values of a cause.
fn reaching(found: &mut Cause, values: &[f64]) {
    for (estimate, value) in found.parameters.values_mut().zip(values) {
        let [low, high] = &mut estimate.ci90;
        if *high > *low && value.is_finite() {
            (*low, *high) = (low.min(*value), high.max(*value));
        }
    }
}

/// A cause with intervals that hold its values in all sets that explain about as much.
fn covering(mut found: Cause, cause: &Candidate, near: &[&Scored]) -> Cause {
    for set in near {
        let Some(i) = set.causes.iter().position(|own| own.is(cause)) else { continue };
        let values = set.values(i);
        let rows = found.parameters.values_mut().zip(values).zip(cause.definition.parameters);
        // Different values of an angle or a signed parameter may mean the same.
        for ((estimate, value), parameter) in rows.filter(|(_, parameter)| parameter.scale == Scale::Log) {
            let [low, high] = estimate.ci90;
            let half = (0.5 * (high - low)).max((value - estimate.value).abs());
            // A value that was not fitted has no interval.
            if high > low && half.is_finite() {
                estimate.ci90 = intervals::within(parameter, estimate.value, half);
            }
        }
    }
    found
}

/// Pairs of kinds that look alike: an accepted kind, and another one that explains about as much in its place
/// or balances the forces as well. A simpler law within the intervals of an accepted law, in `effects`,
/// counts too. The pair `known` looks alike on these records whatever was fitted.
pub(super) fn look_alikes(
    accepted: &Scored,
    field: &Field,
    balanced: &[&Scored],
    effects: &[Cause],
    known: Option<[Kind; 2]>,
) -> Vec<[Kind; 2]> {
    let mut found: Vec<[Kind; 2]> = known.into_iter().collect();
    let best = field.evidence.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let own = field.sets.iter().zip(&field.evidence).find(|(set, _)| set.is_same(accepted));
    let own = own.map_or(best, |(_, evidence)| *evidence);
    // A law that contains the accepted one may predict clearly better, and still explain little more.
    let is_near = |(rival, _, evidence): &(&Scored, f64, f64)| {
        best - evidence < LOOK_ALIKE || is_outer(accepted, rival) && evidence - own > PARSIMONY
    };
    let near = field.rivals(accepted).filter(is_near);
    for (rival, ..) in field.rivals(accepted) {
        // Either part may instead be their sum.
        if let Some((sum, parts)) = sum_of(rival, accepted) {
            found = parts.map(|part| [part, sum]).to_vec();
        }
    }
    let single = |rival: &Scored| match (&accepted.beyond(rival)[..], &rival.beyond(accepted)[..]) {
        ([(_, mine)], [(_, theirs)]) => Some([mine.definition.kind, theirs.definition.kind]),
        _ => None,
    };
    // A balance separates kinds, not places.
    let of_balance = |rival: &&Scored| {
        let kinds = |scored: &Scored| scored.causes.iter().map(|c| c.definition.kind).collect::<Vec<_>>();
        let (own, theirs) = (kinds(accepted), kinds(rival));
        let other = theirs.iter().copied().find(|kind| !own.contains(kind))?;
        Some([own.iter().copied().find(|kind| !theirs.contains(kind))?, other])
    };
    let pairs = near.filter_map(|(rival, ..)| single(rival));
    let pairs: Vec<[Kind; 2]> = pairs.chain(balanced.iter().filter_map(of_balance)).collect();
    for (cause, effect) in accepted.causes.iter().zip(effects) {
        let outer = cause.definition.kind;
        let values: Vec<&Estimate> = effect.parameters.values().collect();
        let inner = LIBRARY.iter().map(|inner| inner.kind).find(|inner| may_be(outer, *inner, &values));
        if let Some(inner) = inner
            && found.len() < MOST_ALIKE
            && !found.contains(&[outer, inner])
        {
            found.push([outer, inner]);
        }
    }
    // A law is always close to a law that it contains, so other pairs come first.
    let is_nested = |[a, b]: &&[Kind; 2]| contains(*a, *b) || contains(*b, *a);
    let (nested, apart): (Vec<_>, Vec<_>) = pairs.iter().partition(is_nested);
    for &pair in apart.into_iter().chain(nested) {
        if found.len() < MOST_ALIKE && pair[0] != pair[1] && !found.contains(&pair) {
            found.push(pair);
        }
    }
    found
}

/// Whether a law equals a simpler law that it contains somewhere within the intervals of its values. It also
/// does if it has several levels and all are equal: presliding alone does not distinguish laws.
fn may_be(outer: Kind, inner: Kind, values: &[&Estimate]) -> bool {
    let own: Vec<f64> = values.iter().map(|estimate| estimate.value).collect();
    let levels = nearest(outer, inner, &own);
    let is_one = |level: &Vec<f64>| {
        let mut rows = level.iter().zip(&levels[0]);
        rows.all(|(a, b)| (a / b - 1.0).abs() < ONE_LEVEL)
    };
    if levels.len() > 1 && levels.iter().all(is_one) {
        return true;
    }
    let is_within = |same: Vec<f64>| {
        let mut rows = same.iter().zip(values);
        rows.all(|(same, estimate)| (estimate.ci90[0]..=estimate.ci90[1]).contains(same))
    };
    levels.iter().filter_map(|values| embed(outer, inner, values)).any(is_within)
}

/// Whether a rival differs from the accepted set only by a law that contains an accepted law.
fn is_outer(accepted: &Scored, rival: &Scored) -> bool {
    match (&accepted.beyond(rival)[..], &rival.beyond(accepted)[..]) {
        ([(_, mine)], [(_, theirs)]) => {
            mine.site == theirs.site && contains(theirs.definition.kind, mine.definition.kind)
        }
        _ => false,
    }
}

/// The cause of a rival that is the sum of two accepted ones, and these. Either may then be true, even if one
/// fits slightly better.
fn sum_of(rival: &Scored, accepted: &Scored) -> Option<(Kind, [Kind; 2])> {
    let [(_, sum)] = rival.beyond(accepted)[..] else { return None };
    let parts = dossier(sum.definition.kind).parts?;
    let own = accepted.beyond(rival);
    let has =
        |kind: &Kind| own.iter().any(|(_, cause)| cause.site == sum.site && cause.definition.kind == *kind);
    (own.len() == parts.len() && parts.iter().all(has)).then_some((sum.definition.kind, parts))
}

/// Whether a rival's last cause is the accepted one on another element of the same place. A flexible joint
/// may be reported as a spring or as a body.
fn is_the_same_elsewhere(accepted: &Scored, rival: &Scored) -> bool {
    let (Some(a), Some(b)) = (accepted.causes.last(), rival.causes.last()) else { return false };
    accepted.causes.len() == rival.causes.len()
        && a.definition.kind == b.definition.kind
        && a.place == b.place
        && a.site != b.site
}

/// The kind of mass that may be meant by a small value of this cause.
fn mass_instead(cause: &Candidate) -> Option<Kind> {
    dossier(cause.definition.kind).mass_instead
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_law_whose_interval_holds_a_simpler_one_may_be_that() {
        let of = |value: f64, half: f64| Estimate {
            value,
            ci90: [value - half, value + half],
            unit: String::new(),
        };
        let may_be = |asymmetry: &Estimate| {
            may_be(Kind::AsymmetricFriction, Kind::CoulombFriction, &[&of(7.0, 0.5), asymmetry])
        };
        assert!(may_be(&of(-0.03, 0.04)) && !may_be(&of(-0.03, 0.02)));
        let lugre = |static_level: f64| {
            let values = [6e4, 900.0, 15.0, static_level, 0.02].map(|value| of(value, 1e-3 * value));
            super::may_be(Kind::LugreFriction, Kind::CoulombFriction, &values.each_ref())
        };
        assert!(lugre(15.1) && !lugre(17.0));
        // Asymmetric friction does not contain Stribeck friction.
        let values = [&of(7.0, 0.5), &of(0.0, 0.04)];
        assert!(!super::may_be(Kind::AsymmetricFriction, Kind::StribeckFriction, &values));
    }
}
