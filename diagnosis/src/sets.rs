//! Sets of causes that are tried together. They are pairs that a balance of forces proposes, and the simpler
//! law in the place of one that contains it.

use rayon::prelude::*;

use crate::budget::Stage;
use crate::fit::balanced::{better, lower};
use crate::fit::candidates::{Candidate, candidates};
use crate::fit::nested::from_base;
use crate::fit::scored::{Scored, distinct};
use crate::fit::screen::Linearised;
use crate::fit::search::{balanced_start, score};
use crate::inverse::Balanced;
use crate::judge::{Judge, PARSIMONY};
use crate::kinds::{apart, nearest, overlaps};

/// Evidence in a balance that a second cause must bring before the pair is fitted, nats.
const WORTH_FITTING: f64 = 6.0;
/// Pairs that are fitted.
const MOST_PAIRS: usize = 4;
/// Share of the best single cause's evidence that another must bring for pairs to be built upon it.
const BASE_SHARE: f64 = 0.4;
/// Causes upon which pairs are built, and pairs upon each that are fitted.
const MOST_BASES: usize = 4;
const PAIRS_OF_A_BASE: usize = 2;
/// Steps after which pairs upon one cause are compared.
const PAIR_STEPS: usize = 4;
/// Share of a cause's evidence that another brings alone, if it is to be tried in its place.
const RIVAL_SHARE: f64 = 0.6;
/// Exchanges that are fitted.
const MOST_EXCHANGES: usize = 8;
/// Steps of their fit.
const STEPS: usize = 10;

impl Judge<'_> {
    /// Pairs of causes that a balance of forces proposes, fitted: those that bring more than either cause
    /// does by itself, the best first.
    pub(crate) fn proposed_pairs(&self) -> Vec<Scored> {
        let task = &self.search.task;
        let Some(inverse) = task.inverse.as_ref().filter(|_| self.weight > 0.0) else { return Vec::new() };
        let all = candidates(&self.dataset.machine);
        let singles: Vec<(Candidate, f64)> = all
            .par_iter()
            .filter_map(|candidate| Some((*candidate, inverse.weigh(&[*candidate])?.nats)))
            .collect();
        let best = singles.iter().map(|(_, nats)| *nats).fold(0.0, f64::max);
        let pairs: Vec<[Candidate; 2]> = (0..singles.len())
            .flat_map(|i| (0..i).map(move |j| (j, i)))
            .map(|(j, i)| [singles[j].0, singles[i].0])
            .filter(|[a, b]| a.site != b.site || !overlaps(a.definition.kind, b.definition.kind))
            .collect();
        let mut proposed: Vec<([Candidate; 2], Balanced)> = pairs
            .into_par_iter()
            .filter(|_| !task.budget.is_over(Stage::Fit))
            .filter_map(|pair| Some((pair, inverse.weigh(&pair)?)))
            .filter(|(_, balanced)| balanced.nats > best + WORTH_FITTING)
            .collect();
        proposed.sort_by(|a, b| b.1.nats.total_cmp(&a.1.nats));
        proposed.truncate(MOST_PAIRS);
        let fit = |(pair, balanced): ([Candidate; 2], Balanced)| {
            let calibrated = &self.search.calibrated.fitted;
            let model =
                pair.iter().zip(&balanced.values).fold(calibrated.model.clone(), |model, (cause, values)| {
                    model.with(cause.site, cause.definition, values)
                });
            let mut start = model.start();
            start[..calibrated.theta.len()].copy_from_slice(&calibrated.theta);
            let start = better(task, &model, start, &balanced);
            score(task, pair.to_vec(), task.fit(&model, &start, STEPS))
        };
        let mut fitted: Vec<Scored> = proposed.into_par_iter().map(fit).collect();
        fitted.retain(|pair| self.is_finding(pair) && self.all(pair).is_finite());
        fitted.sort_by(|a, b| self.all(b).total_cmp(&self.all(a)));
        fitted
    }

    /// Pairs that no single cause led to, fitted. The best single cause need not be one of two: where
    /// friction and a mass act, a lag or a dead band may explain more alone than either. So pairs are also
    /// built upon others that did well alone. `known` were tried already.
    pub(crate) fn other_pairs(&self, known: &[&Scored]) -> Vec<Scored> {
        let task = &self.search.task;
        let mut alone: Vec<&Scored> = self.search.singles.iter().chain(&self.search.others).collect();
        alone.retain(|single| self.all(single) > 0.0);
        alone.sort_by(|a, b| self.all(b).total_cmp(&self.all(a)));
        let overlap =
            |a: &Candidate, b: &Candidate| a.site == b.site && overlaps(a.definition.kind, b.definition.kind);
        let best = alone.first().map_or(0.0, |best| self.all(best));
        let mut bases: Vec<&Scored> = Vec::new();
        for single in &alone {
            let is_law_of_another = bases.iter().any(|base| overlap(&base.causes[0], &single.causes[0]));
            if self.all(single) > BASE_SHARE * best && bases.len() < MOST_BASES && !is_law_of_another {
                bases.push(single);
            }
        }
        let is_known = |pair: [&Candidate; 2]| {
            let has = |scored: &Scored, cause: &Candidate| scored.causes.iter().any(|other| other.is(cause));
            known.iter().any(|set| set.causes.len() == 2 && pair.iter().all(|cause| has(set, cause)))
        };
        let begin = |base: &&Scored| {
            let first = base.causes[0];
            let partners: Vec<&Scored> = (alone.iter().copied())
                .filter(|other| !overlap(&first, &other.causes[0]) && !is_known([&first, &other.causes[0]]))
                .collect();
            if partners.is_empty() || task.budget.is_over(Stage::Screen) {
                return Vec::new();
            }
            let Some(linearised) = Linearised::new(task, &base.fitted) else { return Vec::new() };
            let screen = |other: &Scored| {
                let second = other.causes[0];
                let values = other.fitted.model.parameters(0, &other.fitted.theta);
                let balanced = task.inverse.as_ref().and_then(|inverse| inverse.weigh(&[first, second]));
                let starts = balanced.as_ref().and_then(|found| balanced_start(found, second));
                let screened = std::iter::once(values).chain(starts).filter_map(|values| {
                    let model = base.fitted.model.with(second.site, second.definition, &values);
                    let mut start = model.start();
                    start[..base.fitted.theta.len()].copy_from_slice(&base.fitted.theta);
                    linearised.screen(&model, &start, PAIR_STEPS)
                });
                let best = screened.min_by(|a, b| a.fitted.cost.total_cmp(&b.fitted.cost))?.fitted;
                let lower = balanced.and_then(|found| lower(task, &best, &found));
                Some((vec![first, second], from_base(task, &base.fitted, lower.unwrap_or(best))))
            };
            let mut screened: Vec<_> = partners.into_par_iter().filter_map(screen).collect();
            screened.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
            screened.truncate(PAIRS_OF_A_BASE);
            screened
        };
        let begun: Vec<_> = bases.par_iter().flat_map(begin).collect();
        let fits = begun.into_par_iter().filter(|_| !task.budget.is_over(Stage::Fit));
        let fits =
            fits.map(|(causes, begun)| score(task, causes, task.fit(&begun.model, &begun.theta, STEPS)));
        let mut fitted = distinct(fits.collect::<Vec<_>>());
        fitted.retain(|pair| self.is_finding(pair) && self.all(pair).is_finite());
        fitted.sort_by(|a, b| self.all(b).total_cmp(&self.all(a)));
        fitted
    }

    /// Several causes with one of them exchanged, fitted: for each cause that is known to look like it, and
    /// for those that did nearly as well alone. Sets that were `tried` are left out.
    pub(crate) fn exchanged(&self, accepted: &Scored, tried: &[Scored]) -> Vec<Scored> {
        if accepted.causes.len() < 2 {
            return Vec::new();
        }
        let all = candidates(&self.dataset.machine);
        let indices = (0..accepted.causes.len()).flat_map(|i| all.iter().map(move |other| (i, other)));
        let is_tried = |i: usize, other: &Candidate| {
            let mut causes = accepted.causes.clone();
            causes[i] = *other;
            let has = |set: &Scored, cause: &Candidate| set.causes.iter().any(|known| known.is(cause));
            tried
                .iter()
                .any(|set| set.causes.len() == causes.len() && causes.iter().all(|cause| has(set, cause)))
        };
        let mut starts: Vec<(usize, Candidate, Vec<f64>, f64)> = indices
            .filter(|(i, other)| !is_tried(*i, other))
            .filter_map(|(i, other)| {
                let (values, alone) = self.start_instead(accepted, i, other)?;
                Some((i, *other, values, alone))
            })
            .collect();
        starts.sort_by(|a, b| b.3.total_cmp(&a.3));
        starts.truncate(MOST_EXCHANGES);
        let fits = starts
            .into_par_iter()
            .map(|(i, other, values, _)| self.with_instead(accepted, i, other, &values));
        fits.filter(|scored| self.is_finding(scored) && self.all(scored).is_finite()).collect()
    }

    /// Values from which a cause can be fitted in the place of cause `i`, and what it explains alone; `None`
    /// if nothing suggests it there.
    fn start_instead(&self, accepted: &Scored, i: usize, other: &Candidate) -> Option<(Vec<f64>, f64)> {
        let gone = &accepted.causes[i];
        let mut causes: Vec<Candidate> = accepted.causes.clone();
        causes.remove(i);
        let is_known = |cause: &Candidate| {
            cause.site == other.site && overlaps(cause.definition.kind, other.definition.kind)
        };
        if other.is(gone) || causes.iter().any(is_known) {
            return None;
        }
        let single = |of: &Candidate| self.search.singles.iter().find(|single| single.causes[0].is(of));
        let alone = single(other).map(|single| (single, self.all(single)));
        let own = single(gone).map_or(f64::INFINITY, |single| self.all(single));
        if let Some((single, nats)) = alone
            && nats > RIVAL_SHARE * own
        {
            return Some((single.fitted.model.parameters(0, &single.fitted.theta), nats));
        }
        let is_alike = apart(gone.definition.kind, other.definition.kind).is_some();
        let inverse = self.search.task.inverse.as_ref().filter(|_| is_alike && self.weight > 0.0)?;
        causes.push(*other);
        let values = inverse.weigh(&causes)?.values.pop()?;
        Some((values, alone.map_or(0.0, |(_, nats)| nats)))
    }

    /// The same causes with a simpler law in the place of one that contains it, where that loses little.
    pub(crate) fn simplified(&self, scored: Scored) -> Scored {
        let all = candidates(&self.dataset.machine);
        let mut best = scored;
        for i in 0..best.causes.len() {
            let outer = best.causes[i];
            let values = best.fitted.model.parameters(i, &best.fitted.theta);
            let simpler = all.iter().filter(|inner| inner.site == outer.site).flat_map(|inner| {
                nearest(outer.definition.kind, inner.definition.kind, &values)
                    .into_iter()
                    .map(move |v| (*inner, v))
            });
            let fits = simpler.map(|(inner, values)| self.with_instead(&best, i, inner, &values));
            let found = fits.max_by(|a, b| self.all(a).total_cmp(&self.all(b)));
            if let Some(found) = found.filter(|found| self.all(&best) - self.all(found) < PARSIMONY) {
                best = found;
            }
        }
        best
    }

    /// The same causes with `other` in the place of cause `i`.
    fn with_instead(&self, scored: &Scored, i: usize, other: Candidate, values: &[f64]) -> Scored {
        let task = &self.search.task;
        let (base, keep) = scored.fitted.model.without(i);
        let model = base.with(other.site, other.definition, values);
        let mut start = model.start();
        for (start, &kept) in start.iter_mut().zip(&keep) {
            *start = scored.fitted.theta[kept];
        }
        let mut causes = scored.causes.clone();
        causes.remove(i);
        causes.push(other);
        let found = task.inverse.as_ref().and_then(|inverse| inverse.weigh(&causes));
        let start = match found {
            Some(found) => better(task, &model, start, &found),
            None => start,
        };
        score(task, causes, task.fit(&model, &start, STEPS))
    }
}
